"""Recordings that the generator wrote, as data sets."""

from pathlib import Path

from identification.dataset.dataset import DataSet
from mechanism.description import read_neck
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise


def read_recordings(folder: Path) -> tuple[DataSet, DataSet]:
    """The fitted one and the one held out."""
    return _read(folder / "fitted"), _read(folder / "held_out")


def _read(here: Path) -> DataSet:
    neck = read_neck(here / "neck.yaml")
    angles, log = read_angles(here / "angles.csv", neck.N), read_log(here / "log.csv", neck)
    return synchronise(neck, "", angles, log, {})
