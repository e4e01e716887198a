"""A recording's result without its stages: a motion by the generator's linkage, a video whose frames tell their number."""

from pathlib import Path
from typing import Any, cast

import numpy as np

from calibration.camera import camera_from
from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet, state_series
from identification.dataset.series import Series, numbered_columns
from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.arm import arm_of
from mechanism.description import read_neck
from samples.generator.camera import SAMPLE_CAMERA
from synchronisation.angles import Angles
from tests.paths import NECK_FILE
from tests.vision.scene import corners
from tests.vision.test_video import film
from vision.extract import Extraction
from vision.linkage.linkage_fit import fit_linkage
from vision.shutter import Shutter
from xneck.recording.camera_stages import VideoResult
from xneck.recording.recording_folder import Recording
from xneck.recording.recording_result import RecordingResult

NECK = NECK_FILE
SECONDS = 2.0
HIDDEN = slice(20, 24)
"""frames in which no marker is seen"""
OFFSET, SKEW_PPM = 0.25, 300.0
"""of the camera's clock, which starts at zero"""


def motion(seconds: np.ndarray) -> np.ndarray:
    """alpha (T, 3), rad."""
    return 0.4 * np.sin(2 * np.pi * np.outer(seconds, [0.5, 0.8, 1.1]) + [0.0, 1.0, 2.0])


def dataset(start: float, forces: bool = True) -> DataSet:
    """Two seconds by a log's clock that shows `start`, filmed by a camera from a quarter of a second on."""
    neck = read_neck(NECK)
    arm = arm_of(neck)
    t = 0.002 * np.arange(1250, dtype=float)
    alpha, rng = motion(t), np.random.default_rng(0)
    theta = rng.normal(size=(len(t), arm.M)).cumsum(axis=0)
    sigma = np.full_like(alpha, 1e-3)
    f = 40 + theta if forces else np.empty((len(t), 0))
    state = state_series(arm, start + t, (alpha, alpha, alpha), (theta, theta, theta), f, (sigma, sigma, sigma))
    frames = np.arange(int(30 * SECONDS)) / 30 + rng.uniform(0, 1e-3, int(30 * SECONDS))
    clock = {"offset_s": start + OFFSET, "skew_ppm": SKEW_PPM, "camera_middle_s": 1.0}
    seen = motion(log_time(clock, frames) - start) + rng.normal(0, 1e-3, (len(frames), 3))
    seen[HIDDEN] = np.nan
    angles = Series(frames, numbered_columns("alpha", seen) | numbered_columns("sigma", np.full_like(seen, 1e-3)))
    log = Series(start + t, numbered_columns("theta", theta) | numbered_columns("f", f))
    return DataSet(
        neck=neck, neck_yaml=NECK.read_text(), state=state, fasquelle=state, angles=angles, log=log, clock=clock
    )


def result(folder: Path, start: float = 3.0) -> RecordingResult:
    """With a film, markers and a pose as they would have been found, and a simulation that is the measurement."""
    data = dataset(start)
    time = data.angles.time
    video = film(folder / "video.mp4", np.rint(90_000 * time).astype(int).tolist())
    c = SAMPLE_CAMERA
    camera = camera_from(np.array([c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2, c.k3]), (c.width, c.height))
    found = corners(data.neck, motion(log_time(data.clock, time) - start))
    found[HIDDEN] = np.nan
    fit = fit_linkage(data.neck, camera, found, "made")
    angles = Angles(time, fit.alpha, data.angles.matrix("sigma"))
    extraction = Extraction(angles, fit, found, Series(time, {}))
    recording = Recording(
        folder=folder,
        config=folder,
        log=folder,
        neck=NECK,
        video=video,
        camera=None,
        board=None,
        pictures=(),
        angles=None,
        shutter=Shutter(),
        estimate_placement=False,
        template=False,
        light=None,
    )
    columns = numbered_columns("alpha", data.state.matrix("alpha")) | numbered_columns(
        "tension", data.state.matrix("f")
    )
    not_shown = cast(Any, None)
    simulated = SimulatedRecording(Series(data.state.time, columns), (), 0.5, "f", not_shown)
    return RecordingResult(
        name="made",
        recording=recording,
        video=VideoResult(camera, None, extraction),
        drawn=None,
        angles=angles,
        data=data,
        fasquelle=not_shown,
        estimates=not_shown,
        model=not_shown,
        simulated=simulated,
        simulation_refused=None,
    )
