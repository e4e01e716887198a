"""Recordings that grow: the sample's video and log, with what a test changes of them."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from calibration.camera_file import write_camera
from mechanism.description import read_neck
from synchronisation.encoder_log import read_log
from tests.xneck.watch.experiment import OFFSET_S, SAMPLE, Array, Experiment, Footage, footage, log_lines
from xneck.recording.camera_stages import camera_of
from xneck.recording.recording_folder import read_recording

Change = Callable[[dict[str, Array]], dict[str, Array]]


@pytest.fixture(scope="session")
def camera_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample's camera."""
    path = tmp_path_factory.mktemp("camera") / "camera.yaml"
    write_camera(camera_of(read_recording(SAMPLE))[0], path)
    return path


@pytest.fixture(scope="session")
def sample_table() -> dict[str, Array]:
    """The sample's log, columns by name."""
    log = read_log(SAMPLE / "log.mcap", read_neck(SAMPLE / "neck.yaml"))
    return {"time": log.time, **log.columns}


@pytest.fixture
def begin(tmp_path: Path, begin_in: Callable[..., Experiment]) -> Callable[..., Experiment]:
    """Begins an experiment in a folder of its own."""
    return partial(begin_in, tmp_path)


@pytest.fixture(scope="session")
def begin_in(camera_file: Path, sample_table: dict[str, Array]) -> Callable[..., Experiment]:
    """Begins an experiment in a folder that is made in the one that is given."""

    def begun(
        inside: Path,
        seconds: float = 12.0,
        change: Change = lambda table: table,
        packets: Footage | None = None,
        corners: str = "edges",
        form: str = "matroska",
        options: dict[str, str] | None = None,
    ) -> Experiment:
        folder = inside / "monday"
        folder.mkdir()
        (folder / "neck.yaml").write_bytes((SAMPLE / "neck.yaml").read_bytes())
        (folder / "camera.yaml").write_bytes(camera_file.read_bytes())
        (folder / "recording.yaml").write_text(
            "video: video.mkv\nlog: log.csv\ncamera: camera.yaml\nneck: neck.yaml\n"
            f"exposure: 0.004\ncorners: {corners}\n"
        )
        before_its_end = sample_table["time"] < OFFSET_S + seconds
        table = {name: values[before_its_end] for name, values in sample_table.items()}
        at = table["time"] - OFFSET_S
        changed = change(dict(table))
        kept = (
            np.isin(table["time"], changed["time"]) if len(changed["time"]) < len(at) else np.ones(len(at), dtype=bool)
        )
        lines = log_lines(changed, at[kept])
        return Experiment(
            folder / "video.mkv",
            folder / "log.csv",
            packets or footage(SAMPLE / "video.mp4", seconds),
            lines,
            form,
            options or {},
        )

    return begun
