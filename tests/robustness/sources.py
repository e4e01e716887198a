"""Small files of every kind that is read, so that damage hits every part of them."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from calibration.camera_file import export_camera, write_camera
from identification.dataset.dataset_file import read_dataset, write_dataset
from identification.dataset.series import Series
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.files import write_angles_csv, write_log_csv, write_log_mcap
from samples.generator.video import render_video
from synchronisation.angles import read_angles, write_angles
from tests.paths import SAMPLES
from tests.vision.linkage.test_linkage_fit import camera

Array = NDArray[np.float64]

R, H = SAMPLES / "recording", SAMPLES / "held_out"
ROWS = 60


def small_files(folder: Path, recorded: Path) -> Path:
    """Angles, logs by format and compression, a data set, a model, neck, camera, board, recording, and a video of some frames."""
    rng = np.random.default_rng(3)
    time = np.arange(ROWS) / 500
    theta, f = rng.normal(0, 5, (ROWS, 4)), rng.uniform(10, 90, (ROWS, 4))
    write_angles_csv(
        folder / "angles.csv", np.arange(ROWS) / 30, rng.normal(0, 0.3, (ROWS, 3)), np.full((ROWS, 3), 0.001)
    )
    write_angles(read_angles(folder / "angles.csv", 3), folder / "angles.mcap")
    write_log_csv(folder / "log.csv", time, theta, f)
    write_log_mcap(folder / "ros.mcap", time, theta, f)
    for kind in (CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD):
        json_log(folder / f"{kind.name.lower()}.mcap", kind, time, theta, f)
    data = read_dataset(recorded / "d.mcap")
    parts = {name: _short(getattr(data, name)) for name in ("state", "fasquelle", "angles", "log", "covariance")}
    write_dataset(replace(data, **parts), folder / "dataset.mcap")
    shutil.copy(recorded / "m.yaml", folder / "model.yaml")
    for name in ("neck.yaml", "board.yaml", "recording.yaml"):
        shutil.copy(R / name, folder / name)
    write_camera(camera(), folder / "camera.yaml")
    export_camera(camera(), folder / "camera.yaml", "opencv")
    neck = yaml.safe_load((R / "neck.yaml").read_text())
    render_video(
        folder / "video.mp4",
        np.arange(8) / 30,
        lambda t: np.zeros((*np.shape(t), 3)),
        neck,
        SAMPLE_CAMERA.scaled(0.25),
        0,
    )
    return folder


def json_log(path: Path, compression: CompressionType, time: Array, theta: Array, f: Array) -> None:
    """A log as JSON in chunks of a few rows; time (T,), s; theta (T, M), rad; f (T, M), N."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=2000, compression=compression)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joints", "json", schema)
        for k, at in enumerate(np.rint(time * 1e9).astype(int).tolist()):
            message = {
                "header": {"stamp": {"sec": at // 10**9, "nanosec": at % 10**9}},
                "name": [f"motor{j + 1}" for j in range(theta.shape[1])],
                "position": theta[k].tolist(),
                "effort": f[k].tolist(),
            }
            writer.add_message(channel, at, json.dumps(message).encode(), at, k)
        writer.finish()


def _short(series: Series) -> Series:
    return Series(series.time[:ROWS], {name: values[:ROWS] for name, values in series.columns.items()})
