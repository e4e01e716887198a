"""Angles lost where a cable, a strip, blur, a shadow or glare is on the markers: ours beside OpenCV's detector.

All get the same video, the same true camera and the same fit of the linkage, which gives no angle (NaN) where a frame's
corners leave it uncertain. OpenCV searches every frame, with each of its refinements; ours follows. An angle is a joint in a frame.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from benchmarks.opencv import searching
from benchmarks.table import Claim, Table
from calibration.camera import Camera, camera_from
from mechanism.description import Neck, markers_of, read_neck
from samples.generator import camera as seen_by
from samples.generator.hard import cases
from vision.extract import ExtractionOptions, extract
from vision.linkage.linkage_fit import fit_linkage
from vision.shutter import Shutter
from vision.video import describe_video, read_frames
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

SAMPLES = Path(__file__).parents[1] / "samples"
SAMPLE_SHARE = 240
"""frames of the sample: OpenCV's APRILTAG takes a quarter of a second for each"""
THEIRS = ("NONE", "SUBPIX", "APRILTAG")
OURS = ("edges", "template")
COLUMNS = (
    "angles",
    *(f"{m} lost" for m in (*THEIRS, *OURS)),
    *(f"{m} alone" for m in OURS),
    *("SUBPIX markers", "edges markers"),
    *(f"{m} deg" for m in (*THEIRS, *OURS)),
    *(f"{m} z" for m in OURS),
)
TITLE = """Hard recordings: angles (joints x frames) that each way loses; those lost by ours alone, that some OpenCV refinement has;
markers x frames lost; RMS error of the angles that are left; ours: error over sigma"""


@dataclass(frozen=True)
class Measured:
    """What one way of finding corners makes of a recording."""

    alpha: Array
    """(F, N), rad, NaN where lost"""
    sigma: Array
    markers_lost: int
    """markers times frames"""


def measure() -> Table:
    """Counts of angles (and markers) lost, RMS error and the spread of error over sigma, of each case."""
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    with tempfile.TemporaryDirectory() as folder:
        for name, case in cases(yaml.safe_load((SAMPLES / "recording/neck.yaml").read_text())).items():
            case.render(Path(folder) / "video.mp4")
            (Path(folder) / "neck.yaml").write_text(yaml.safe_dump(case.neck))
            neck = read_neck(Path(folder) / "neck.yaml")
            rows.append((name, row(Path(folder) / "video.mp4", neck, case.camera, case.truth())))
    claim = _claim(rows)
    neck = read_neck(SAMPLES / "recording/neck.yaml")
    truth = np.load(SAMPLES / "truth.npz")["recording_frame_alpha"][:SAMPLE_SHARE]
    rows.insert(0, ("the sample", row(SAMPLES / "recording/video.mp4", neck, seen_by.SAMPLE_CAMERA, truth)))
    return Table(TITLE, COLUMNS, tuple(rows), (claim,))


def _claim(rows: list[tuple[str, tuple[float | None, ...]]]) -> Claim:
    """Over all hard cases, ours as it is by default beside whichever refinement loses least."""
    summed = {name: sum(figures[k] or 0 for _, figures in rows) for k, name in enumerate(COLUMNS)}
    best = min(THEIRS, key=lambda name: summed[f"{name} lost"])
    what = f"angles lost of {summed['angles']:g}"
    on, peer = "markers partly hidden, blurred or glaring", (f"OpenCV {best}", summed[f"{best} lost"])
    return Claim(what, on, summed["template lost"], peer)


def row(video: Path, neck: Neck, view: seen_by.Camera, truth: Array) -> tuple[float | None, ...]:
    """One recording's figures, in the order of COLUMNS; truth (F, N) of as many frames as are looked at."""
    camera = true_camera(view)
    theirs = {m: by_opencv(m, video, neck, camera, len(truth)) for m in THEIRS}
    ours = {c: by_ours(c, video, neck, camera, view.exposure_s, len(truth)) for c in OURS}
    known = ~np.all([np.isnan(m.alpha) for m in theirs.values()], axis=0)
    every = [*theirs.values(), *ours.values()]
    return (
        truth.size,
        *(int(np.isnan(m.alpha).sum()) for m in every),
        *(int((np.isnan(m.alpha) & known).sum()) for m in ours.values()),
        theirs["SUBPIX"].markers_lost,
        ours["edges"].markers_lost,
        *(rms(np.degrees(m.alpha - truth)) for m in every),
        *(rms((m.alpha - truth) / m.sigma) for m in ours.values()),
    )


def rms(values: Array) -> float | None:
    """Root of the mean square of what is known; None where nothing is."""
    return float(np.sqrt(np.nanmean(values**2))) if np.isfinite(values).any() else None


def true_camera(c: seen_by.Camera) -> Camera:
    """The generator's camera as a calibration would give it without error."""
    return camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))


def by_opencv(refinement: str, video: Path, neck: Neck, camera: Camera, count: int) -> Measured:
    """Corners by OpenCV in every full frame of the first `count`, then the fit of the linkage."""
    markers = markers_of(neck, "neck.yaml")
    find = searching(markers.dictionary, refinement)
    hidden = np.full((4, 2), np.nan)
    seen = []
    for frame in read_frames(video):
        if frame.index == count:
            break
        found = find(frame.grey)
        seen.append([found.get(m.id, hidden) for m in markers.on_bars])
    corners = np.array(seen)
    lost = int(np.isnan(corners[:, :, 0, 0]).sum())
    try:
        fit = fit_linkage(neck, camera, corners, "benchmark")
    except Refused:  # nothing to begin with: all is lost
        nothing = np.full((len(corners), neck.N), np.nan)
        return Measured(nothing, nothing, lost)
    return Measured(fit.alpha, np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2)), lost)


def by_ours(corners: str, video: Path, neck: Neck, camera: Camera, exposure_s: float, count: int) -> Measured:
    """As `xneck extract --corners ... --exposure ...` does it."""
    found = extract(
        describe_video(video), camera, neck, ExtractionOptions(Shutter(exposure_s), template=corners == "template")
    )
    lost = int(np.isnan(found.corners[:count, :, 0, 0]).sum())
    return Measured(found.angles.alpha[:count], found.angles.sigma[:count], lost)
