"""The folder in which the examples of docstrings and pages run: two recordings of the sample, run once."""

import shutil
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest

import xneck
from diagnosis.diagnose import Diagnosis
from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series
from identification.simulation.simulated_motion import motion_columns
from tests.docs.pages import ROOT
from xneck.batch.recording_task import run_recording_task
from xneck.recording.recording_folder import read_recording


@pytest.fixture(scope="session")
def sample_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `xneck run` writes of the sample's two recordings."""
    out = tmp_path_factory.mktemp("results")
    for name in ("recording", "held_out"):
        run_recording_task(read_recording(ROOT / "samples" / name), out / name)
    return out


@pytest.fixture(scope="session")
def examples(sample_results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """samples/, monday.mcap (from the video), tuesday.mcap, model.yaml of monday, motion.csv."""
    folder = tmp_path_factory.mktemp("examples")
    for name, day in (("recording", "monday"), ("held_out", "tuesday")):
        shutil.copytree(ROOT / "samples" / name, folder / "samples" / name)
        shutil.copy(sample_results / name / "dataset.mcap", folder / f"{day}.mcap")
    shutil.copy(sample_results / "recording/model.yaml", folder)
    monday = xneck.read_dataset(folder / "monday.mcap")
    moving = monday.state.part(slice(1000, 2000))  # two seconds of what was played, as a motion that was designed
    columns = {name: moving.columns[name] for name in motion_columns(monday.neck)}
    export_series(Series(moving.time, columns), folder / "motion.csv")
    return folder


@pytest.fixture(scope="session")
def asked_once() -> dict[str, object]:
    """xneck's slow functions, each of which answers the same question once."""
    synchronise, diagnose = xneck.synchronise, xneck.diagnose
    read = cache(xneck.read_dataset)
    made = {"samples/recording": "monday.mcap", "samples/held_out": "tuesday.mcap"}
    diagnosed: dict[tuple[int, ...], Diagnosis] = {}

    def synchronised(folder: str) -> DataSet:
        return read(made[folder]) if folder in made else synchronise(folder)

    def diagnosed_once(fitted: Sequence[DataSet], held_out: Sequence[DataSet]) -> Diagnosis:
        asked = (*map(id, fitted), 0, *map(id, held_out))  # `read` keeps them, so that no other has their id
        if asked not in diagnosed:
            diagnosed[asked] = diagnose(fitted, held_out)
        return diagnosed[asked]

    return {"read_dataset": read, "synchronise": synchronised, "diagnose": diagnosed_once}


@pytest.fixture
def in_examples(examples: Path, asked_once: dict[str, object], monkeypatch: pytest.MonkeyPatch) -> Path:
    """There, with these."""
    monkeypatch.chdir(examples)
    for name, function in asked_once.items():
        monkeypatch.setattr(xneck, name, function)
    return examples
