"""Whole files of senseless contents: read or refused, and where a command goes on with them, a result that is whole."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibration.board import read_board
from calibration.corner_detection import BoardView
from calibration.estimation import calibrate
from calibration.observations import Observations, observe_board
from calibration.pictures import read_pictures
from identification.dataset.dataset_file import dataset_series, read_dataset
from identification.files import joint_state
from mechanism.description import read_neck
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from tests.calibration.truth import SIZE, synthetic_views
from tests.robustness.contents import ANY_JSON, joint_states, pictures, tables
from tests.robustness.judge import TRIED, check, done_or_refused, read, run, some
from tests.robustness.sources import H, R
from tests.robustness.test_commands import of_a_dataset, place, readable
from xneck.cli import COMMANDS, group
from xneck.recording.recording_folder import read_recording
from xneck.recording.result_folder import stored_refusal, stored_result
from xneck.study.plan import Case
from xneck.study.run_cases import stored_record
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import replacing_any_file, write_text

NECK, BOARD = read_neck(R / "neck.yaml"), read_board(R / "board.yaml")
NUMBER = count()
READERS: list[Callable[[Path], Any]] = [
    lambda path: read_log(path, NECK),
    lambda path: read_angles(path, 3),
    read_dataset,
]


@some(60)
@given(make=joint_states(), reader=st.sampled_from(READERS))
def test_joint_states(make: Callable[[Path], None], reader: Callable[[Path], Any], tmp_path: Path) -> None:
    path = tmp_path / f"{next(NUMBER)}.mcap"
    make(path)
    read("whole MCAP", path, reader)
    path.unlink()


@some(60)
@given(make=tables(), reader=st.sampled_from(READERS[:2]))
def test_tables(make: Callable[[Path], None], reader: Callable[[Path], Any], tmp_path: Path) -> None:
    path = tmp_path / f"{next(NUMBER)}.csv"
    make(path)
    read("whole CSV", path, reader)
    path.unlink()


@some(40)
@given(
    records=st.fixed_dictionaries(dict.fromkeys(("clock", "check", "provenance"), ANY_JSON)), which=st.integers(0, 7)
)
def test_records_of_a_data_set(records: dict[str, Any], which: int, small: Path, tmp_path: Path) -> None:
    """Metadata of any JSON in a data set that is well otherwise."""
    data = read_dataset(small / "dataset.mcap")
    own = {name: dict(getattr(data, name)) for name in records}
    mixed = {name: records[name] if which >> k & 1 else own[name] for k, name in enumerate(records)}
    path = tmp_path / f"{next(NUMBER)}.mcap"
    joint_state.write(path, dataset_series(data), mixed, {"neck.yaml": data.neck_yaml.encode()})
    read("whole records", path, read_dataset)
    path.unlink()


@some(25)
@given(changes=st.lists(pictures(), min_size=1, max_size=2))
def test_pictures_of_a_board(changes: list[Callable[[bytes], tuple[str, bytes]]], tmp_path: Path) -> None:
    folder = tmp_path / str(next(NUMBER))
    folder.mkdir()
    files = []
    for k, change in enumerate(changes):
        suffix, content = change((R / "board/01.jpg").read_bytes())
        files.append(folder / f"picture{k}{suffix}")
        files[-1].write_bytes(content)
    done_or_refused("whole pictures", lambda: observe_board(read_pictures(files), BOARD))
    shutil.rmtree(folder)


@st.composite
def of_views(draw: st.DrawFn) -> Callable[[list[BoardView]], list[BoardView]]:
    """Corners of a board that no camera has seen: views alike, few, mirrored, in a line, far off, exchanged, of two boards."""
    kind = draw(
        st.sampled_from(["few", "alike", "mirrored", "line", "far", "exchanged", "point", "scaled", "noise", "half"])
    )
    keep, share, seed = draw(st.integers(1, 12)), draw(st.floats(0, 1)), draw(st.integers(0, 999))

    def made(views: list[BoardView]) -> list[BoardView]:
        rng = np.random.default_rng(seed)
        chosen = [view for view in views if rng.random() < share] or views[:1]
        changed = []
        for view in views[:keep]:
            points = view.image_points.copy()
            if view in chosen:
                if kind == "alike":
                    points = views[0].image_points + 1e-3 * rng.normal(size=points.shape)
                elif kind == "mirrored":
                    points[:, 0] = SIZE[0] - points[:, 0]
                elif kind == "line":
                    points[:, 1] = points[:, 0]
                elif kind == "far":
                    points += rng.normal(0, 1e6, 2)
                elif kind == "exchanged":
                    points = rng.permutation(points)
                elif kind == "point":
                    points[:] = points[0]
                elif kind == "scaled":
                    points *= 10.0 ** rng.integers(-6, 6)
                elif kind == "noise":
                    points += rng.normal(0, 50, points.shape)
            view = replace(view, image_points=points)
            changed.append(view.of(rng.random(len(points)) < 0.5) if kind == "half" else view)
        return changed

    return made


@some(25, shrunk=False)
@given(change=of_views())
def test_corners_of_a_board(change: Callable[[list[BoardView]], list[BoardView]]) -> None:
    views = change(synthetic_views(np.random.default_rng(7), BOARD.corners, 12))
    found = done_or_refused("corners", lambda: calibrate(Observations(tuple(views), (), SIZE)))
    assert found is None or np.all(np.isfinite(found.camera.parameters))


@some(2, shrunk=False)
@given(change=of_a_dataset())
def test_diagnose(change: Callable[[Any], Any], recorded: Path, tmp_path: Path) -> None:
    here = place(tmp_path)
    dataset, out = here / "d.mcap", here / "out"
    made = change(read_dataset(recorded / "d.mcap"))
    records = {name: dict(getattr(made, name)) for name in ("clock", "check", "provenance")}
    joint_state.write(dataset, dataset_series(made), records, {"neck.yaml": made.neck_yaml.encode()})
    before = dataset.read_bytes()
    ran = run("diagnose data set", "diagnose", dataset, "--held-out", recorded / "d.mcap", "--out", out, "--quiet")
    names = ("diagnosis.html", "diagnosis.figures.json", "diagnosis.json", "neck.yaml", "model.yaml")
    readers = {out / name: readable if name.endswith("json") else (lambda path: path.read_text()) for name in names}
    check(ran, readers, (dataset, recorded / "d.mcap"))
    assert dataset.read_bytes() == before


CASE = Case(("tip_payload",), 100, "rich", 1.0, 0.1, (60.0, 60.0))


@some(40)
@given(record=ANY_JSON, signed=st.booleans())
def test_records_of_a_study_and_of_results(record: Any, signed: bool, tmp_path: Path) -> None:
    """A record counts where xneck wrote it for these files, and then only; anything else there is done anew, or refused."""
    recording = read_recording(H)
    for name in (f"{CASE.name}.json", "result.json", "refused.json"):
        path = tmp_path / name
        if signed:
            with replacing_any_file():
                write_text(path, json_text(record))
        else:
            path.write_text(json.dumps(record))
    TRIED["stored records"] += 3
    assert stored_result(recording, tmp_path) is None
    assert stored_refusal(recording, tmp_path) is None
    written = json.loads(json_text(record)) if signed and isinstance(record, dict) else None  # NaN is null there
    assert stored_record(CASE, tmp_path) == written


WORDS = (
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e-320",
    "1e308",
    "9" * 400,
    "",
    "text",
    "é",
    "-",
    "--",
    "\x1b[31m",
    "a\nb",
    "%s",
    "../..",
    "∞",
    "１",
)


@st.composite
def told(draw: st.DrawFn) -> list[str]:
    """A command with values that its options do not expect, and files that are there or not."""
    name = draw(st.sampled_from([name for name in COMMANDS if name not in ("demo", "study", "run")]))
    command = group.get_command(click.Context(group), name)
    assert command is not None
    words = [name]
    for param in command.params:
        if param.name == "help" or not (param.required or draw(st.integers(0, 3)) == 0):
            continue
        if isinstance(param, click.Option) and param.is_flag:
            words.append(param.opts[0])
            continue
        values = [
            draw(st.sampled_from(WORDS)) if draw(st.booleans()) else f"{{{param.name}}}"
            for _ in range(max(1, param.nargs))
        ]
        words += values if isinstance(param, click.Argument) else [param.opts[0], *values]
    return words


@some(60)
@given(words=told())
def test_values_of_options(words: list[str], small: Path, tmp_path: Path) -> None:
    """Status 1 or 2 with few words, or 0 with a result; no traceback, and no input is changed."""
    here = place(tmp_path)
    known = {"video": "video.mp4", "neck_file": "neck.yaml", "camera_file": "camera.yaml", "board_file": "board.yaml"}
    known |= {"angles_file": "angles.csv", "log_file": "log.csv", "dataset": "dataset.mcap", "datasets": "dataset.mcap"}
    known |= {
        "baseline": "dataset.mcap",
        "held_out": "dataset.mcap",
        "model_file": "model.yaml",
        "source": "board.yaml",
    }
    before = {path: path.read_bytes() for path in small.iterdir()}

    def file(word: str) -> str:
        if not word.startswith("{"):
            return word
        name = word.strip("{}")
        return str(small / known[name]) if name in known else str(here / "out" / f"{name}.mcap")

    ran = run("options", *(file(word) for word in words), "--quiet")
    assert ran.status in (0, 1, 2)
    assert "Traceback" not in ran.err
    assert len(ran.err) < 1000, ran.err
    assert "\x1b" not in ran.err
    assert {path: path.read_bytes() for path in small.iterdir()} == before
    shutil.rmtree(here)


@pytest.mark.parametrize(
    "name", ["a\nb", "\x1b[31mred", "-rf", "%d %s", "é", "a:b", "http:", "'\"", "x" * 200, "`id`", "$(id)", " "]
)
def test_names_of_files_are_only_names(name: str, small: Path, tmp_path: Path) -> None:
    """Whatever a folder is called, one line tells what is wrong, and what it says can be printed."""
    here = tmp_path / name
    here.mkdir()
    shutil.copy(small / "log.csv", here / "log.csv")
    (here / "angles.csv").write_text("time,alpha1\n0,0\n")
    ran = run(
        "names", "sync", here / "angles.csv", here / "log.csv", "--neck", small / "neck.yaml", "--out", here / "d.mcap"
    )
    assert ran.status == 1
    assert ran.err.count("\n") == 1, ran.err
    assert ran.err.rstrip("\n").isprintable(), ran.err
    assert "lacks the columns alpha2, alpha3" in ran.err
