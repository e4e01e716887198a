"""A recording's result to make pages of: the start of a sample, with a calibration, frames and a simulation made up."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np

from calibration.estimation import Calibration, calibrate
from calibration.observations import LeftOut, Observations
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.estimates import LAWS_BY_ELASTIC_MODEL, estimate
from identification.fasquelle.method import fasquelle_identification
from identification.model_file import model_of
from identification.simulation.channels import Channel
from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.description import read_neck
from synchronisation.angles import Angles, read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from tests.calibration.truth import synthetic_views
from tests.paths import SAMPLES
from vision.extract import Extraction
from vision.linkage.linkage_fit import LinkageFit
from vision.overlay_video import small_overlay
from vision.shutter import Shutter
from vision.video import Frame
from xneck.recording.camera_stages import VideoResult
from xneck.recording.drawn_video import AnnotatedFrame, DrawnVideo
from xneck.recording.recording_folder import Recording
from xneck.recording.recording_result import RecordingResult
from xneck_foundation.provenance import note_inputs, provenance

SAMPLE = SAMPLES / "held_out"
SECONDS = 8.0
NASTY = "<script>alert(1)</script>"


def sample_start(folder: Path) -> tuple[DataSet, Angles]:
    """The first seconds of the held-out sample, with a gap of ten frames and a file name that tries to be markup."""
    neck = read_neck(SAMPLE / "neck.yaml")
    angles = read_angles(SAMPLE / "angles.csv", neck.N)
    kept = angles.time < SECONDS
    alpha, sigma = angles.alpha[kept].copy(), angles.sigma[kept].copy()
    alpha[100:110] = sigma[100:110] = np.nan
    notes = {"markers": [{"id": 7, "seen_share": 0.9, "duplicates": 1}], "foreign_ids": [3], "warnings": [NASTY]}
    angles = Angles(angles.time[kept], alpha, sigma, notes)
    # a slash cannot be in a file name, but it can be in the provenance of a data set that somebody else made
    (folder / "log").write_bytes(b"log")
    origin = provenance(note_inputs({"log": folder / "log"}))
    origin["inputs"]["log"]["file"] = NASTY + ".mcap"
    yaml = (SAMPLE / "neck.yaml").read_text() + f"# {NASTY}\n"
    return synchronise(neck, yaml, angles, read_log(SAMPLE / "log.mcap", neck), origin), angles


def some_calibration() -> Calibration:
    x, y = np.meshgrid(np.arange(8) * 0.025, np.arange(5) * 0.025)
    corners = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    views = synthetic_views(np.random.default_rng(0), corners, count=8)
    return calibrate(Observations(tuple(views), (LeftOut(f"{NASTY}.png", "the board was not found"),), (1280, 720)))


def some_simulation(data: DataSet) -> SimulatedRecording:
    """As simulation gives it: windows of a second, that drift away from what was measured."""
    state, samples = data.state, 500
    kept = len(state) // samples * samples
    drift = 0.02 * np.tile(np.linspace(0, 1, samples), kept // samples)[:, None]
    columns: dict[str, np.ndarray] = {}
    for stem in ("alpha", "theta"):
        measured = state.matrix(stem)[:kept]
        columns |= numbered_columns(stem, measured + drift) | numbered_columns(stem, measured, "_measured")
    channels = tuple(Channel(name, 0.01, 0.005, "rad", 1.4) for name in columns if not name.endswith("_measured"))
    return SimulatedRecording(Series(state.time[:kept], columns), channels, 1.0, "f", cast(Any, None))


def _brightening(times: np.ndarray) -> Iterator[Frame]:
    """Frames that grow brighter one by one, so that each tells its number."""
    for index, time in enumerate(times.tolist()):
        yield Frame(index, time, np.full((720, 1280), 16 + 200 * index // len(times), dtype=np.uint8))


def sample_result(folder: Path) -> RecordingResult:
    """The start of the held-out sample through identification, with a calibration, frames and a simulation that are made up."""
    data, angles = sample_start(folder)
    fasquelle = fasquelle_identification([data])
    calibration = some_calibration()
    frames, joints = angles.alpha.shape
    fit = LinkageFit(
        alpha=angles.alpha,
        covariance=np.zeros((frames, joints, joints)),
        rvec=np.zeros(3),
        tvec=np.array([0.0, 0.0, 1.0]),
        pose_sigma=np.zeros(6),
        corner_sigma_px=0.07,
        residual_px=np.zeros(frames),
    )
    extraction = Extraction(angles, fit, np.zeros((frames, 4, 4, 2)), Series(angles.time, {}))
    rng = np.random.default_rng(1)
    picture = rng.integers(0, 255, (72, 128, 3), dtype=np.uint8).repeat(10, axis=0).repeat(10, axis=1)
    return RecordingResult(
        name=NASTY,
        recording=Recording(
            folder=folder,
            config=folder / "recording.yaml",
            log=folder / "log",
            neck=SAMPLE / "neck.yaml",
            video=None,
            camera=None,
            board=None,
            pictures=(),
            angles=None,
            shutter=Shutter(),
            estimate_placement=False,
            template=False,
            light=None,
        ),
        video=VideoResult(calibration.camera, calibration, extraction),
        drawn=DrawnVideo(
            (AnnotatedFrame(0, picture), AnnotatedFrame(frames - 1, picture)),
            small_overlay(_brightening(angles.time), data.neck, calibration.camera, extraction),
        ),
        angles=angles,
        data=data,
        fasquelle=fasquelle,
        estimates=estimate([data]),
        model=model_of(fasquelle.elastic[1].parameters, LAWS_BY_ELASTIC_MODEL[1], {}),
        simulated=some_simulation(data),
        simulation_refused=None,
    )
