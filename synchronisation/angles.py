"""Joint angles over the camera's own clock: what extraction gives, and what angles from elsewhere are read into."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset_file import export_series
from identification.dataset.frames import MAX_SIGMA_RAD, ordinary_frames, white_sigma
from identification.dataset.series import Series, check_order, check_time, from_one, numbered_columns
from identification.dataset.time_unit import check_repeated_rows, check_time_unit
from identification.files import joint_state
from synchronisation.csv_header import other_kind
from synchronisation.csv_lines import file_line
from synchronisation.csv_table import PLAIN, read_table
from synchronisation.held_frames import held_frames
from synchronisation.misread_angles import marks_of_nothing, misread
from synchronisation.sigma_by_frames import sigma_by_frames
from xneck_foundation.errors import Refused
from xneck_foundation.file_kind import refuse_other_kind
from xneck_foundation.one_line import listed
from xneck_foundation.recovery import warn_recovered

Array = NDArray[np.float64]

MAX_TURNS = 2
"""turns by which angles may be wound up that are called radians still"""
ANGLES_SUFFIXES = (".csv", ".mcap")
"""of angles that are read"""
MAX_BEYOND_SHARE = 0.05
"""of all angles: fewer that are beyond +-pi are misread, and the others are radians (docs/thresholds.md)"""
MAX_DEGREES = 180.0
"""largest angle that is thought to be in degrees where it cannot be in rad (docs/thresholds.md)"""


@dataclass(frozen=True)
class Angles:
    """Angles of F frames and N joints, NaN where not seen."""

    time: Array
    """(F,), s, camera clock"""
    alpha: Array
    """(F, N), rad"""
    sigma: Array
    """(F, N), rad: standard deviation of alpha"""
    notes: dict[str, Any] = field(default_factory=dict)
    """where the angles come from: provenance, camera pose, marker statistics; `light`: exposure and delay of a switched light"""
    light: Array | None = None
    """(F,): brightness of a light that the controller switches, NaN where not known; None without a light"""
    common: Array | None = None
    """(F, N), rad: the part of sigma that all frames share (camera pose, placement of markers); None where not known"""
    noise: Mapping[str, Any] | None = None
    """what sigma is by the scatter of the frames (sigma_by_frames.py, tested_sigma.py); None until that was looked at"""
    held: int = 0
    """frames that are left out because they hold the angles of the frame before (held_frames.py)"""

    @property
    def series(self) -> Series:
        """Columns alpha1..N, sigma1..N and, where known, common1..N."""
        columns = numbered_columns("alpha", self.alpha) | numbered_columns("sigma", self.sigma)
        return Series(self.time, columns | ({} if self.common is None else numbered_columns("common", self.common)))

    @property
    def shared(self) -> Array:
        """The part of sigma that all frames share, (F, N), rad; zero where not known."""
        return np.zeros_like(self.sigma) if self.common is None else self.common

    @property
    def white_sigma(self) -> Array:
        """The part of sigma that differs from frame to frame, (F, N), rad."""
        return white_sigma(self.sigma, self.shared)

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Frames in which every angle is known, (F,)."""
        return np.asarray(np.isfinite(self.alpha).all(axis=1))

    def from_zero(self, zero: Array) -> "Angles":
        """Counted from where the joints stand straight, of angles that read `zero` (N,), rad, there."""
        return replace(self, alpha=self.alpha - zero)

    @property
    def ordinary(self) -> NDArray[np.bool_]:
        """Frames that have a say in the clock, (F,)."""
        return ordinary_frames(self.alpha, self.sigma)


def write_angles(angles: Angles, path: str | Path, quality: Series | None = None) -> None:
    """Writes MCAP (.mcap, with the notes and each frame's quality), or .csv, .npz, .mat with the columns alone."""
    if Path(path).suffix.lower() == ".mcap":
        series = {"angles": angles.series} | ({"quality": quality} if quality else {})
        joint_state.write(path, series, {"angles": angles.notes})
    else:
        export_series(angles.series, path)


def read_angles(path: str | Path, joints: int, filmed: bool = True) -> Angles:
    """Angles of an arm with `joints` mechanisms, from angles.mcap or from anyone's CSV `time,alpha1..N[,sigma1..N]`.

    filmed: frames follow each other as those of a film; else they may be minutes apart.
    Raises Refused for missing columns, times that do not increase, or values that cannot be radians.
    """
    path = Path(path)
    if path.suffix.lower() == ".mcap":
        series, notes, light = _from_mcap(path)
        return checked_angles(series, joints, path, notes, light, filmed=filmed)
    series, notes, light = _from_csv(path, joints)
    return checked_angles(series, joints, path, notes, light, file_line(path, PLAIN.separator), filmed)


def checked_angles(
    series: Series,
    joints: int,
    path: str | Path,
    notes: dict[str, Any],
    light: Array | None = None,
    number: Callable[[int], int] = from_one,
    filmed: bool = True,
) -> Angles:
    """Angles from columns alpha1..N and optional sigma1..N and common1..N; `path` says where they come from.

    number: what a person calls a row, which is counted from 0. filmed: as of `read_angles`. Raises Refused as that does.
    """
    check_repeated_rows(series, str(path), "frames")
    if filmed:
        check_time_unit(series.time, str(path), "frames")
        check_time(series.time, str(path), number)
    else:
        check_order(series.time, str(path), number)
    alpha, sigma, common = series.matrix("alpha"), series.matrix("sigma"), series.matrix("common")
    if alpha.shape[1] == joints:
        alpha = _without_misread(alpha, path, number)
    _check_angles(alpha, common, joints, path, number)
    held = held_frames(alpha)
    alpha = np.where(held[:, None], np.nan, alpha)
    noise = None
    if sigma.shape[1] != joints:
        by_frames = sigma_by_frames(series.time, alpha)
        noise = by_frames.record
        sigma = by_frames.sigma if common.shape[1] != joints else np.hypot(by_frames.sigma, common)
    else:
        sigma = _checked_sigma(alpha, sigma, path, number)
    return Angles(
        time=series.time,
        alpha=alpha,
        sigma=sigma,
        notes=notes,
        light=light,
        common=common if common.shape[1] == joints else None,
        noise=noise,
        held=int(held.sum()),
    )


def _from_mcap(path: Path) -> tuple[Series, dict[str, Any], Array | None]:
    """Columns, notes and the light's brightness of an angles.mcap."""
    recording = joint_state.read(path)
    recording.refuse_faulty(path, "angles", "quality")
    if "angles" not in recording.logs:
        names = {name for log in recording.logs.values() for name in log.names}
        if told := other_kind(names, angles_expected=True):
            raise Refused(path, *told)
        raise Refused(
            path,
            f"has no /angles, only {listed(f'/{name}' for name in recording.logs)}",
            "`xneck extract` makes one; where a log is given too, angles come first",
        )
    series = joint_state.as_series(recording.logs["angles"])
    light = None
    if "quality" in recording.logs:
        light = _light(series.time, joint_state.as_series(recording.logs["quality"]))
    if light is not None and "angles" not in recording.metadata:
        raise Refused(path, f"has lost what it says of the light ({recording.lost})", "copy it again")
    return series, recording.metadata.get("angles", {}), light


def _from_csv(path: Path, joints: int) -> tuple[Series, dict[str, Any], Array | None]:
    """Columns, notes and the light's brightness of anyone's CSV."""
    optional = [f"{stem}{i + 1}" for stem in ("sigma", "common") for i in range(joints)]
    further = f"alpha{joints + 1}"
    refuse_other_kind(path, ANGLES_SUFFIXES)
    series = read_table(path, [f"alpha{i + 1}" for i in range(joints)], optional=[*optional, "light", further])
    if further in series.columns:
        raise Refused(path, f"has {further}, the arm has {joints} mechanisms", "is it the right neck.yaml?")
    return series, {"source": path.name}, series.columns.get("light")


def _check_angles(alpha: Array, common: Array, joints: int, path: str | Path, number: Callable[[int], int]) -> None:
    """Refused where angles (F, N), rad, are not those of an arm with `joints` mechanisms."""
    if alpha.shape[1] != joints:
        raise Refused(
            path, f"has {alpha.shape[1]} angles, the arm has {joints} mechanisms", "is it the right neck.yaml?"
        )
    if np.isnan(alpha).all():
        raise Refused(path, "has no angle at all")
    if np.isinf(common).any():
        raise Refused(
            path, "has an infinite common1..N", "give the part of sigma that all frames share, in rad, or none"
        )
    if (largest := float(np.nanmax(np.abs(alpha)))) <= np.pi:
        return
    what = f"has an angle of {largest:.4g}, and angles are radians, within +-pi"
    if _turned_round(alpha):
        raise Refused(
            path, f"{what}: some are a whole turn too large", "bring alpha1..N to within +-pi, by whole turns"
        )
    if np.nanmean(np.abs(alpha) > np.pi) < MAX_BEYOND_SHARE:
        row, joint = (int(k[0]) for k in np.nonzero(np.abs(alpha) > np.pi))
        what = f"{what}: alpha{joint + 1} in row {number(row)}, and few others"
        raise Refused(path, what, "leave angles blank that are misread")
    degrees = largest <= MAX_DEGREES
    raise Refused(
        path,
        what + ": these are degrees" * degrees,
        "multiply alpha1..N by 0.0174533" if degrees else "is it alpha, of one bar against the one below?",
    )


def _without_misread(alpha: Array, path: str | Path, number: Callable[[int], int]) -> Array:
    """Angles (F, N), rad, NaN where they are marks of frames without an angle or misread, with a warning."""
    alpha = alpha.copy()
    for mark, frames in marks_of_nothing(alpha).items():
        alpha[frames] = np.nan
        what = f"{mark:g} stands for all angles in {frames.sum()} frames (the first in row {number(int(np.argmax(frames)))})"
        warn_recovered(
            path, f"{what}, far from those beside them: they were taken for not seen; leave such angles blank"
        )
    wrong = misread(alpha)
    if wrong.any():
        rows, joints = np.nonzero(wrong)
        first = f"alpha{joints[0] + 1} of {alpha[rows[0], joints[0]]:.3g} rad in row {number(int(rows[0]))}"
        warn_recovered(
            path, f"{wrong.sum()} angles jump away from the frames about them and back (the first is {first}): left out"
        )
    alpha[wrong] = np.nan
    return alpha


def _checked_sigma(alpha: Array, sigma: Array, path: str | Path, number: Callable[[int], int]) -> Array:
    """Standard deviations (F, N), rad, NaN where there is no angle and none is said. Refused where one of an angle cannot be it."""
    valid = (sigma > 0) & (sigma <= MAX_SIGMA_RAD)
    wrong = ~valid & ~np.isnan(alpha)
    if wrong.any():
        row, joint = (int(k[0]) for k in np.nonzero(wrong))
        value, place = sigma[row, joint], f"in row {number(row)}"
        what = f"sigma{joint + 1} is {value:g} {place}, and standard deviations are above 0 and up to {MAX_SIGMA_RAD:g} rad"
        if np.isnan(value):
            what = f"sigma{joint + 1} is missing {place}, where alpha{joint + 1} is {alpha[row, joint]:g}"
        elif value == 0:
            what = f"sigma{joint + 1} is 0 {place}: no angle is without error"
        raise Refused(
            path, what, "give standard deviations in rad, or leave sigma1..N out: they are then told by the scatter"
        )
    return np.where(valid, sigma, np.nan)


def _turned_round(alpha: Array) -> bool:
    """Whether angles (F, N) are radians but for whole turns: all that are beyond +-pi are near a turn, as no degrees all are.

    An X-joint turns by less than a right angle, so that its angle less whole turns is within +-pi/2; of degrees half are not."""
    beyond = alpha[np.abs(alpha) > np.pi]
    turns = np.rint(beyond / (2 * np.pi))
    return bool(
        np.all((np.abs(turns) >= 1) & (np.abs(turns) <= MAX_TURNS) & (np.abs(beyond - 2 * np.pi * turns) < np.pi / 2))
    )


def _light(time: Array, quality: Series) -> Array | None:
    """The light's brightness at frames (F,), s; NaN where a damaged file lost a frame's quality, None without a light."""
    if "light" not in quality.columns:
        return None
    brightness = dict(zip(quality.time.tolist(), quality.columns["light"].tolist(), strict=True))
    return np.array([brightness.get(t, np.nan) for t in time.tolist()])
