"""Every reader of files either reads or refuses, whatever a file has been through."""

from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration.board import read_board
from calibration.camera_file import read_camera
from calibration.pictures import read_pictures
from identification.dataset.dataset_file import read_dataset
from identification.model_file import read_model
from mechanism.description import read_neck
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from tests.robustness.damage import Damage, of_bytes, of_rows, of_values
from tests.robustness.judge import read, some
from tests.robustness.sources import R
from vision.video import read_frames
from xneck.recording.recording_folder import read_recording

NECK = read_neck(R / "neck.yaml")
NUMBER = count()

TABLES: dict[str, Callable[[Path], Any]] = {
    "angles.csv": lambda path: read_angles(path, 3),
    "log.csv": lambda path: read_log(path, NECK),
}
YAMLS: dict[str, Callable[[Path], Any]] = {
    "neck.yaml": read_neck,
    "model.yaml": read_model,
    "board.yaml": read_board,
    "camera.yaml": read_camera,
    "camera.opencv.yaml": read_camera,
    "recording.yaml": read_recording,
}
MCAPS: dict[str, Callable[[Path], Any]] = {
    **dict.fromkeys(("ros.mcap", "none.mcap", "lz4.mcap", "zstd.mcap"), TABLES["log.csv"]),
    "angles.mcap": TABLES["angles.csv"],
    "dataset.mcap": read_dataset,
}
PICTURES: dict[str, Callable[[Path], Any]] = {
    "video.mp4": lambda path: sum(1 for _ in read_frames(path)),
    "01.jpg": lambda path: list(read_pictures([path])),
}


def tried(kind: str, whole: Path, damage: Damage, place: Path, reader: Callable[[Path], Any]) -> None:
    path = place / f"{next(NUMBER)}-{whole.name}"
    path.write_bytes(damage(whole.read_bytes()))
    read(kind, path, reader)
    path.unlink()


@pytest.mark.parametrize("name", [*TABLES, *YAMLS, *MCAPS])
def test_whole_files_are_read(name: str, small: Path) -> None:
    """So that what is refused below is refused for its damage."""
    if name != "recording.yaml":
        assert read("whole", small / name, (TABLES | YAMLS | MCAPS)[name]) is not None


@pytest.mark.parametrize("name", TABLES)
@some(60)
@given(damage=st.one_of(of_rows(), of_rows(), of_bytes()))
def test_tables(name: str, damage: Damage, small: Path, tmp_path: Path) -> None:
    tried("CSV", small / name, damage, tmp_path, TABLES[name])


@pytest.mark.parametrize("name", YAMLS)
@some(60)
@given(damage=st.one_of(of_values(), of_values(), of_bytes()))
def test_yaml(name: str, damage: Damage, small: Path, tmp_path: Path) -> None:
    tried("YAML", small / name, damage, tmp_path, YAMLS[name])


@pytest.mark.parametrize("name", MCAPS)
@some(60)
@given(damage=of_bytes())
def test_mcap(name: str, damage: Damage, small: Path, tmp_path: Path) -> None:
    tried("MCAP", small / name, damage, tmp_path, MCAPS[name])


@pytest.mark.parametrize("name", PICTURES)
@some(25)
@given(damage=of_bytes())
def test_pictures(name: str, damage: Damage, small: Path, tmp_path: Path) -> None:
    whole = R / "board" / name if name == "01.jpg" else small / name
    tried("video and pictures", whole, damage, tmp_path, PICTURES[name])
