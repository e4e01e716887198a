"""Markers in planes of their own, as bars lie beside each other: bias of the angles, ours beside AprilTag's detector tag by tag.

Mounting, motion and the camera's place are drawn for each arm; neck.yaml says nothing of them. Compressed by H.264, 20 s each.
Each of pyapriltags' tags is read by itself, by its own pose in the true camera; against it stand all markers as one linkage.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from benchmarks.apriltag import apriltags
from benchmarks.hard import true_camera
from benchmarks.table import Claim, Table
from mechanism.description import Neck
from mechanism.printed_markers import WORKSHOP_DEPTH_SIGMA
from samples.generator.mounted import MountedArm, mounted_arm
from vision.extract import Extraction, ExtractionOptions, extract
from vision.linkage.shared_fit import TILT_SIGMA
from vision.shutter import Shutter
from vision.video import describe_video, read_frames

Array = NDArray[np.float64]

NECK = Path(__file__).parents[1] / "samples/recording/neck.yaml"
SEEDS = range(1001, 1011)
ROWS = (
    "nothing said",
    "depth said to 1 mm",
    "a marker more, on diagonal A2",
    "nothing said, mounted as loosely as is taken for granted",
    "pyapriltags, tag by tag",
)
LOOSE = {"planes": float(np.sqrt(3.0)) * WORKSHOP_DEPTH_SIGMA, "tilt": TILT_SIGMA}
"""mounting with the spread that the fit takes for granted where nothing is said"""
COLUMNS = ("arms", "with bias up to 0.04 deg", "worst bias deg", "frame rms deg", "z of bias", "false drift")


@dataclass(frozen=True)
class _Seen:
    """One arm's angles by one way."""

    bias: Array
    """(N,), deg"""
    rms: float
    """of single frames about the truth, deg"""
    z: Array
    """(N,): bias over its sigma; NaN where none is stated"""
    drifts: int


def measure() -> Table:
    """Bias and error of angles over arms that are mounted anew."""
    neck = yaml.safe_load(NECK.read_text())
    leaning = {"id": 4, "diagonal": "A2"}
    more = neck | {"markers": neck["markers"] | {"on_bars": [*neck["markers"]["on_bars"], leaning]}}
    found: dict[str, list[_Seen]] = {row: [] for row in ROWS}
    for seed in SEEDS:
        with tempfile.TemporaryDirectory() as folder:
            video = Path(folder) / "video.mp4"
            arm = mounted_arm(neck, seed)
            arm.render(video)
            found[ROWS[0]].append(_ours(arm, video, _described(neck)))
            found[ROWS[1]].append(_ours(arm, video, _described(neck, arm.depth())))
            found[ROWS[4]].append(_tag_by_tag(arm, video))
            arm = mounted_arm(more, seed)
            arm.render(video)
            found[ROWS[2]].append(_ours(arm, video, _described(more)))
            arm = mounted_arm(neck, seed, **LOOSE)
            arm.render(video)
            found[ROWS[3]].append(_ours(arm, video, _described(neck)))
    rows = tuple((name, _figures(seen)) for name, seen in found.items())
    claim = Claim(
        "worst bias of a joint, deg",
        f"{len(SEEDS)} arms with markers within 8 mm of one plane",
        dict(rows)[ROWS[0]][2],
        (ROWS[4], dict(rows)[ROWS[4]][2]),
    )
    return Table("Markers in planes of their own, 43 px wide, H.264, 20 s", COLUMNS, rows, (claim,))


def _described(neck: dict[str, Any], depth: Array | None = None) -> Neck:
    on_bars = [dict(m) for m in neck["markers"]["on_bars"]]
    for m, d in zip(on_bars, () if depth is None else depth, strict=False):
        m |= {"depth": float(d), "depth_sigma": 0.001}
    return Neck.model_validate(neck | {"markers": neck["markers"] | {"on_bars": on_bars}}, strict=False)


def _ours(arm: MountedArm, video: Path, neck: Neck) -> _Seen:
    options = ExtractionOptions(shutter=Shutter(exposure_s=arm.camera.exposure_s))
    found: Extraction = extract(describe_video(video), true_camera(arm.camera), neck, options)
    fit, error = found.fit, found.fit.alpha - arm.truth
    noise = np.zeros_like(fit.covariance) if fit.noise is None else fit.noise
    common = np.sqrt(np.diagonal(np.nanmean(fit.covariance - noise, axis=0)))
    bias = np.nanmean(error, axis=0)
    return _Seen(np.degrees(bias), float(np.degrees(np.sqrt(np.nanmean(error**2)))), bias / common, len(fit.drift))


def _tag_by_tag(arm: MountedArm, video: Path) -> _Seen:
    """Each bar's direction from its own marker's pose, against the base marker's."""
    markers, camera = arm.neck["markers"], true_camera(arm.camera)
    find = apriltags(markers["dictionary"], decimate=1.0)
    s = markers["size"] / 2
    square = np.array([[-s, s, 0], [s, s, 0], [s, -s, 0], [-s, -s, 0]])
    rotation = arm.camera.T_camera_base[:3, :3]
    turns = np.full((len(arm.times), len(markers["on_bars"])), np.nan)
    for frame in read_frames(video):
        for number, corners in find(frame.grey):
            rays = camera.rays(corners)
            solved, turn, _ = cv2.solvePnP(square, rays, np.eye(3), np.zeros(5), flags=cv2.SOLVEPNP_IPPE_SQUARE)
            if solved and number < turns.shape[1]:
                along = rotation.T @ cv2.Rodrigues(turn)[0][:, 0]
                turns[frame.index, number] = np.arctan2(along[1], along[0])
    alpha = np.diff(np.unwrap(turns - turns[:, :1], axis=1), axis=1)
    error = np.angle(np.exp(1j * (alpha - arm.truth)))
    nothing = np.full(alpha.shape[1], np.nan)
    bias = np.nanmean(error, axis=0)
    return _Seen(np.degrees(bias), float(np.degrees(np.sqrt(np.nanmean(error**2)))), nothing, 0)


def _figures(seen: list[_Seen]) -> tuple[float | None, ...]:
    worst = [float(np.max(np.abs(s.bias))) for s in seen]
    z = np.concatenate([s.z for s in seen])
    return (
        len(seen),
        sum(w <= 0.04 for w in worst),
        max(worst),
        float(np.sqrt(np.mean([s.rms**2 for s in seen]))),
        float(np.sqrt(np.mean(z**2))) if np.isfinite(z).all() else None,
        sum(s.drifts > 0 for s in seen),
    )
