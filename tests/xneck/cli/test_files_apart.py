"""No command writes to a file that it reads, or twice to one file, by whatever path or link it is told to."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import click
import pytest

from tests.paths import SAMPLES
from tests.robustness.judge import run
from xneck.cli import COMMANDS, group
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE, OutputFolder
from xneck_foundation.whole_file import write_text


def command(name: str) -> click.Command:
    found = group.get_command(click.Context(group), name)
    assert found is not None
    return found


def files_of(name: str) -> tuple[list[click.Parameter], list[click.Parameter]]:
    """Parameters of a command that name files to read, and files to write."""
    params = command(name).params
    inputs = [p for p in params if p.type is INPUT_FILE]
    return inputs, [p for p in params if isinstance(p.type, type(OUTPUT_FILE))]


def pairs() -> Iterator[tuple[str, str, str]]:
    for name in COMMANDS:
        inputs, outputs = files_of(name)
        yield from ((name, str(i.name), str(o.name)) for o in outputs for i in inputs)


TOGETHER = {"ca_file", "certificate", "key"}
"""options that go together, and with --cluster"""


def words(name: str, folder: Path, changed: dict[str, Path]) -> list[str]:
    """A command with a file of xneck's own for each parameter that it must or may be given, but for those in `changed`."""
    told = [name]
    if TOGETHER & set(changed):
        told += ["--cluster", "tls://127.0.0.1:1"]
        changed = {param: folder / f"{param}.yaml" for param in TOGETHER} | changed
    for param in command(name).params:
        is_file = param.type is INPUT_FILE or isinstance(param.type, type(OUTPUT_FILE) | OutputFolder)
        is_folder = isinstance(param, click.Argument) and not is_file and param.required
        wanted = param.name in changed or (is_file and param.required) or is_folder
        if not wanted:
            continue
        path = changed.get(str(param.name), folder if is_folder else folder / f"{param.name}.yaml")
        told += [str(path)] if isinstance(param, click.Argument) else [param.opts[0], str(path)]
    return told


def link(kind: str, target: Path) -> Path:
    made: dict[str, Callable[[], Path]] = {
        "itself": lambda: target,
        "detour": lambda: target.parent / "." / "sub" / ".." / target.name,
        "symbolic link": lambda: target.with_name(f"symbolic{target.suffix}"),
        "hard link": lambda: target.with_name(f"hard{target.suffix}"),
        "linked folder": lambda: target.parent / "again" / target.name,
    }
    path = made[kind]()
    if kind == "symbolic link":
        path.symlink_to(target)
    elif kind == "hard link":
        os.link(target, path)
    elif kind == "linked folder":
        path.parent.symlink_to(target.parent)
    elif kind == "detour":
        (target.parent / "sub").mkdir()
    return path


@pytest.mark.parametrize(("name", "read", "written"), list(pairs()))
@pytest.mark.parametrize("kind", ["itself", "detour", "symbolic link", "hard link", "linked folder"])
def test_an_output_that_is_an_input_is_refused_even_by_force(
    name: str, read: str, written: str, kind: str, tmp_path: Path
) -> None:
    files = [tmp_path / f"{param.name}.yaml" for param in files_of(name)[0]]
    for file in files:
        write_text(file, f"{file.name}: 1\n")
    before = {file: file.read_bytes() for file in files}
    told = words(name, tmp_path, {read: tmp_path / f"{read}.yaml", written: link(kind, tmp_path / f"{read}.yaml")})
    for force in ([], ["--force"]):
        ran = run("outputs apart", *told, *force)
        assert ran.status == 1, ran
        assert "is an input too" in ran.err, ran.err
    assert {file: file.read_bytes() for file in files} == before


@pytest.mark.parametrize("name", [name for name in COMMANDS if len(files_of(name)[1]) > 1])
def test_two_outputs_in_one_file_are_refused(name: str, tmp_path: Path) -> None:
    outputs = [str(p.name) for p in files_of(name)[1]]
    for param in files_of(name)[0]:
        write_text(tmp_path / f"{param.name}.yaml", "a: 1\n")
    for k, first in enumerate(outputs):
        for second in outputs[k + 1 :]:
            told = words(name, tmp_path, {first: tmp_path / "both.yaml", second: tmp_path / "both.yaml"})
            ran = run("outputs apart", *told)
            assert ran.status == 1, ran
            assert "are one file" in ran.err, ran.err
            assert not (tmp_path / "both.yaml").exists()


def test_an_export_beside_out_is_an_output_as_well(tmp_path: Path) -> None:
    for name in ("angles.csv", "log.csv", "neck.yaml"):
        (tmp_path / name).write_text("a: 1\n")
    told = ["sync", *(str(tmp_path / n) for n in ("angles.csv", "log.csv")), "--neck", str(tmp_path / "neck.yaml")]
    ran = run("outputs apart", *told, "--out", tmp_path / "angles.mcap", "--export", "csv")
    assert "angles.csv: --export csv is an input too, ANGLES" in ran.err
    ran = run("outputs apart", *told, "--out", tmp_path / "d.mcap", "--export", "npz", "--json", tmp_path / "d.npz")
    assert "are one file" in ran.err


def test_a_camera_for_other_tools_and_a_reports_figures_are_outputs_as_well(tmp_path: Path) -> None:
    for name in ("a.png", "board.yaml"):
        (tmp_path / name).write_text("a: 1\n")
    told = ["calibrate", str(tmp_path / "a.png"), "--board", str(tmp_path / "board.yaml"), "--out"]
    ran = run("outputs apart", *told, tmp_path / "c.yaml", "--export", "opencv", "--json", tmp_path / "c.opencv.yaml")
    assert "are one file" in ran.err
    ran = run(
        "outputs apart",
        *told,
        tmp_path / "c.yaml",
        "--report",
        tmp_path / "r.html",
        "--json",
        tmp_path / "r.figures.json",
    )
    assert "are one file" in ran.err


def test_results_in_a_folder_spare_inputs_and_the_record(tmp_path: Path) -> None:
    out = tmp_path / "d"
    out.mkdir()
    write_text(out / "model.yaml", "a: 1\n")
    before = (out / "model.yaml").read_bytes()
    ran = run("outputs apart", "diagnose", out / "model.yaml", "--out", out)
    assert f"results would replace {out / 'model.yaml'}, an input (DATASET...)" in ran.err
    write_text(tmp_path / "a.mcap", "")
    ran = run("outputs apart", "diagnose", tmp_path / "a.mcap", "--out", out, "--json", out / "diagnosis.json")
    assert "is one of the files that go to" in ran.err
    assert (out / "model.yaml").read_bytes() == before


def test_every_folder_for_results_says_which_files_go_there() -> None:
    for name in COMMANDS:
        out = [param for param in command(name).params if param.name == "out"]
        assert not out or isinstance(out[0].type, type(OUTPUT_FILE) | OutputFolder), name


@pytest.mark.parametrize("name", ["set.csv", "set.MAT"])
def test_a_data_set_is_not_written_under_the_name_of_another_format(name: str, tmp_path: Path) -> None:
    sample = SAMPLES / "held_out"
    read = [str(sample / file) for file in ("angles.csv", "log.csv")]
    ran = run("other format", "sync", *read, "--neck", str(sample / "neck.yaml"), "--out", str(tmp_path / name))
    assert ran.status == 1
    assert "would be an MCAP" in ran.err
    assert "call it set.mcap" in ran.err
    assert list(tmp_path.iterdir()) == []
