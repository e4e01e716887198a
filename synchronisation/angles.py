"""Joint angles over the camera's own clock: what extraction gives, and what angles from elsewhere are read into."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset_file import export
from identification.dataset.frames import DEFAULT_SIGMA, LARGEST_SIGMA, white
from identification.dataset.series import Series, check_time, numbered
from identification.files import joint_state
from synchronisation.csv_table import read_table
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Angles:
    """time (F,), s, camera clock; alpha and sigma (F, N), rad, NaN where not seen."""

    time: Array
    alpha: Array
    sigma: Array
    notes: dict[str, Any] = field(default_factory=dict)
    """where they come from: provenance, camera pose, marker statistics; of a switched light its exposure and delay"""
    light: Array | None = None
    """(F,): grey level where a light that the controller switches was seen; None without one"""
    common: Array | None = None
    """(F, N), rad: the part of sigma that all frames share (camera pose, placement of markers), if known"""

    @property
    def series(self) -> Series:
        """The columns of the contract."""
        columns = numbered("alpha", self.alpha) | numbered("sigma", self.sigma)
        return Series(self.time, columns | ({} if self.common is None else numbered("common", self.common)))

    @property
    def shared(self) -> Array:
        """`common`, or zeros."""
        return np.zeros_like(self.sigma) if self.common is None else self.common

    @property
    def white(self) -> Array:
        """The part of sigma that differs from frame to frame, (F, N), rad."""
        return white(self.sigma, self.shared)

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Frames in which every angle is known, (F,)."""
        return np.asarray(np.isfinite(self.alpha).all(axis=1))


def write_angles(angles: Angles, path: str | Path, quality: Series | None = None) -> None:
    """As MCAP (.mcap, with the notes, and each frame's quality) or as .csv, .npz, .mat."""
    if Path(path).suffix == ".mcap":
        series = {"angles": angles.series} | ({"quality": quality} if quality else {})
        joint_state.write(path, series, {"angles": angles.notes})
    else:
        export(angles.series, path)


def read_angles(path: str | Path, joints: int) -> Angles:
    """Angles of an arm with `joints` mechanisms, from angles.mcap or from anyone's CSV `time,alpha1..N[,sigma1..N]`.

    Raises Refused for missing columns, times that do not increase, or values that cannot be radians.
    """
    path = Path(path)
    if path.suffix == ".mcap":
        found = joint_state.read(path)
        logs = found.logs
        if "angles" not in logs:
            raise Refused(path, f"has no /angles, only /{', /'.join(logs)}", "make it with `xneck extract`")
        series, notes = joint_state.as_series(logs["angles"]), found.metadata.get("angles", {})
        light = _light(series.time, joint_state.as_series(logs["quality"])) if "quality" in logs else None
        if light is not None and "angles" not in found.metadata:
            raise Refused(path, f"has lost what it says of the light ({found.lost})", "copy it again")
    else:
        wanted = [f"alpha{i + 1}" for i in range(joints)]
        stems = ("sigma", "common")
        optional = [f"{stem}{i + 1}" for stem in stems for i in range(joints)]
        series = read_table(path, wanted, optional=[*optional, "light"])
        light = series.columns.get("light")
        notes = {"source": path.name}
    check_time(series.time, str(path))
    alpha, sigma = series.matrix("alpha"), series.matrix("sigma")
    if alpha.shape[1] != joints:
        raise Refused(
            path, f"has {alpha.shape[1]} angles, the arm has {joints} mechanisms", "is it the right neck.yaml?"
        )
    if np.isnan(alpha).all():
        raise Refused(path, "has no angle at all")
    if np.isinf(series.matrix("common")).any():
        raise Refused(
            path, "has an infinite common1..N", "give the part of sigma that all frames share, in rad, or none"
        )
    if np.nanmax(np.abs(alpha)) > np.pi:
        raise Refused(path, f"has an angle of {np.nanmax(np.abs(alpha)):.1f}", "angles are radians, within +-pi")
    if sigma.shape[1] != joints:
        notes = notes | {"sigma_assumed_rad": DEFAULT_SIGMA}
        sigma = np.where(np.isnan(alpha), np.nan, DEFAULT_SIGMA)
    elif not np.all((sigma[~np.isnan(alpha)] > 0) & (sigma[~np.isnan(alpha)] <= LARGEST_SIGMA)):
        raise Refused(
            path, f"has a sigma that is not within 0 and {LARGEST_SIGMA:g}", "give standard deviations in rad, or none"
        )
    common = series.matrix("common")
    return Angles(series.time, alpha, sigma, notes, light, common if common.shape[1] == joints else None)


def _light(time: Array, quality: Series) -> Array | None:
    """The light's brightness at frames (F,), s; NaN where a damaged file lost the frame's quality."""
    if "light" not in quality.columns:
        return None
    found = dict(zip(quality.time.tolist(), quality.columns["light"].tolist(), strict=True))
    return np.array([found.get(at, np.nan) for at in time.tolist()])
