"""A batch ends with all results, is known from before, and runs again what changed."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import xneck.batch.recording_task
import xneck.batch.run_batch
import xneck.recording.software_versions
from tests.command import Ran, run
from tests.xneck.batch.recordings import FRAMES, NASTY
from xneck.batch.outcome import RecordingOutcome
from xneck.recording.recording_folder import read_recording
from xneck.recording.result_folder import stored_result


def test_it_ends_with_all_results_and_the_failures_by_name(batch: tuple[Path, Ran]) -> None:
    out, ran = batch
    assert ran.status == 1
    lines = {name: line for line in ran.out.splitlines() for name in (NASTY, "broken", "cut", "empty") if name in line}
    assert re.search(r"\d+ of \d+ .* s ± .* ms .*consistent .*fs", lines[NASTY])
    assert "failed: log.csv: lacks the column f3" in lines["broken"]
    assert re.search(f"{FRAMES} of {FRAMES} .*log.mcap: is cut off; /joint_states has", lines["cut"])
    assert "failed: has no recording.yaml; " in lines["empty"]
    assert "4 recordings: 2 done, 2 failed\n" in ran.out
    *failures, warning = ran.err.splitlines()
    assert warning.startswith("xneck: warning: cut: log.mcap: is cut off; ")
    assert [line.split(" failed: ")[0] for line in failures] == ["xneck: broken", "xneck: empty"]
    told = json.loads((out / "summary.json").read_text())
    assert (told["done"], told["failed"]) == (2, 2)
    assert told["recordings"]["cut"]["recovered"][0].startswith("log.mcap: is cut off")


def test_nothing_half_written_is_left(batch: tuple[Path, Ran]) -> None:
    names = {path.relative_to(batch[0]).as_posix() for path in batch[0].rglob("*") if path.is_file()}
    results = (
        "dataset.mcap",
        "model.yaml",
        "simulated.mcap",
        "report.html",
        "report.figures.json",
        "result.json",
        "foxglove.json",
        "plotjuggler.xml",
    )
    assert names == {
        "summary.html",
        "summary.json",
        "broken/refused.json",
        f"{NASTY}/notes.txt",
        *(f"{name}/{file}" for name in (NASTY, "cut") for file in results),
    }


@contextmanager
def idle(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Where nothing is run: the names of what would be."""
    asked: list[str] = []

    def instead(pending: dict[str, Any], *_: Any) -> Iterator[Any]:
        asked.extend(pending)
        yield from (RecordingOutcome(name, None, "not run", done_before=False) for name in pending)

    with monkeypatch.context() as patch:
        patch.setattr(xneck.batch.run_batch, "_run_pending", instead)
        yield asked


def test_the_second_run_does_nothing(
    recordings: list[Path], batch: tuple[Path, Ran], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    out, first = batch
    before = {path: path.stat().st_mtime_ns for path in out.glob("*/*")}
    with idle(monkeypatch) as asked:
        again = run(capfd, "run", *recordings, "--out", out, "--json", out / "all.json")
    assert asked == []
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/*")} == before
    assert (again.status, again.err) == (1, first.err)
    assert again.out.count("done before") == 2
    assert re.search(r"log\.csv: lacks the column f3; .* \(as before\)", again.out)
    told = json.loads((out / "all.json").read_text())
    assert Path(told["recordings"]["cut"]["report"]).is_file()
    assert (told["done"], set(told["failed"])) == (2, {"broken", "empty"})
    assert [line.startswith("cut: log.mcap: is cut off") for line in told["recovered"]] == [True]


def test_what_changed_is_done_again_and_nothing_else(
    recordings: list[Path],
    batch: tuple[Path, Ran],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    home, out = tmp_path / "recordings", tmp_path / "results"
    shutil.copytree(recordings[0].parent, home)  # copies are as old as their originals
    shutil.copytree(batch[0], out)

    def redone(*words: str) -> list[str]:
        with idle(monkeypatch) as asked:
            run(capfd, "run", *sorted(home.iterdir()), "--out", out, *words)
        return asked

    assert redone() == []
    (home / "cut/log.mcap").touch()
    assert redone() == [], "a time alone is no change"
    kept = json.loads((out / "cut/result.json").read_text())["made_from"]["inputs"]["log"]
    assert kept["mtime_ns"] == (home / "cut/log.mcap").stat().st_mtime_ns, "nor a reason to hash it each time"
    text = (home / "cut/angles.csv").read_text()
    (home / "cut/angles.csv").write_text(text.replace("0", "1", 1))
    assert redone() == ["cut"]
    (home / "cut/angles.csv").write_text(text)
    assert redone() == []
    (home / "broken/recording.yaml").open("a").write("exposure: 0.002\n")
    assert redone() == ["broken"]
    (out / NASTY / "report.html").unlink()
    assert redone() == [NASTY, "broken"]
    monkeypatch.setattr(xneck.recording.software_versions, "source_digest", lambda *_: "other sources")
    assert redone() == [NASTY, "broken", "cut"]
    monkeypatch.undo()
    assert redone("--redo") == [NASTY, "broken", "cut"]


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a scheduler with one worker, started as on other machines: by dask's own commands, in another folder."""
    place = tmp_path_factory.mktemp("elsewhere")
    note = place / "scheduler.json"
    common = ["--scheduler-file", str(note), "--no-dashboard"]
    alone = {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path), "OMP_NUM_THREADS": "1"}
    options: Any = {"cwd": place, "env": os.environ | alone, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", *common]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "2", *common]
    # a worker without its scheduler would try to reach it for eight seconds: it ends first
    with running(scheduler, **options) as first, running(worker, **options):
        address = json.loads(written(note, first))["address"]
        from distributed import Client

        with Client(address) as client:
            client.wait_for_workers(1, timeout=120)
        yield address


@contextmanager
def running(words: list[str], **options: Any) -> Iterator["subprocess.Popen[Any]"]:
    """A process that ends with the block, however that ends."""
    with subprocess.Popen(words, **options) as process:
        try:
            yield process
        finally:
            process.terminate()


def written(note: Path, writer: "subprocess.Popen[Any]") -> str:
    """A file of one line that another process writes: it may be there, and still empty."""
    for _ in range(2400):
        assert writer.poll() is None
        if note.exists() and (text := note.read_text()).rstrip().endswith("}"):
            return text
        time.sleep(0.05)
    raise AssertionError(f"{note} is not written")


def test_another_machine_comes_to_the_same(
    recordings: list[Path], batch: tuple[Path, Ran], elsewhere: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out, _ = batch
    ran = run(capfd, "run", *recordings, "--out", tmp_path, "--cluster", elsewhere)
    assert ran.status == 1
    for name in (NASTY, "cut"):
        for file in ("dataset.mcap", "model.yaml", "simulated.mcap", "report.html"):
            assert (tmp_path / name / file).read_bytes() == (out / name / file).read_bytes(), file
        here, there = (json.loads((folder / name / "result.json").read_text()) for folder in (out, tmp_path))
        assert here.pop("seconds") > 0
        assert there.pop("seconds") > 0
        assert here.pop("written_by") != there.pop("written_by")  # by the seconds
        assert here == there
    refused = [json.loads((folder / "broken/refused.json").read_text()) for folder in (out, tmp_path)]
    assert refused[0] == refused[1]


def test_one_alone_is_refused_in_one_line(
    recordings: list[Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    broken = next(path for path in recordings if path.name == "broken")
    for _ in range(2):
        ran = run(capfd, "run", broken, "--out", tmp_path)
        assert (ran.status, ran.out) == (1, "")
        assert re.fullmatch(r"xneck: .*broken/log\.csv: lacks the column f3.*\n", ran.err)
    assert not (tmp_path / "summary.json").exists()


def test_one_alone_is_known_from_before(
    recordings: list[Path], batch: tuple[Path, Ran], capfd: pytest.CaptureFixture[str]
) -> None:
    place = next(path for path in recordings if path.name == "cut")
    assert stored_result(read_recording(place), batch[0] / "cut") is not None
    assert stored_result(read_recording(place), batch[0] / "cut", rerun=True) is None, "it has no recording.rrd yet"
    ran = run(capfd, "run", place, "--out", batch[0])
    assert ran.status == 0
    first, *identified = ran.out.splitlines()
    assert re.fullmatch(r"cut: 270 of 270 frames, offset .*report\.html \(done before\)", first)
    assert any(re.fullmatch(r"  stiffness k: (.* \+- .*, ){3}.* \+- .* N/m", line) for line in identified)
    assert ran.err.startswith("xneck: warning: cut: log.mcap: is cut off")


def test_an_interruption_leaves_what_is_done_and_no_parts(
    recordings: list[Path],
    batch: tuple[Path, Ran],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "results"
    shutil.copytree(batch[0] / "cut", out / "cut")
    whole = {path.name: path.read_bytes() for path in (out / "cut").iterdir()}

    @contextmanager
    def no_workers(*_: Any) -> Iterator[None]:
        yield None

    def interrupted(*_: Any) -> Iterator[Any]:
        (out / NASTY).mkdir()
        (out / NASTY / ".dataset.xneck-0a1b2c3d.mcap").touch()
        (out / "cut/.result.xneck-0a1b2c3d.json").touch()
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(xneck.batch.run_batch, "worker_pool", no_workers)
    monkeypatch.setattr(xneck.batch.run_batch, "run_tasks", interrupted)
    ran = run(capfd, "run", *recordings, "--out", out, "--redo")
    assert (ran.status, ran.out) == (130, "")
    assert ran.err.endswith("; nothing half-written is left; what is done is kept: the same command does the rest\n")
    assert {path.name: path.read_bytes() for path in (out / "cut").iterdir()} == whole
    assert {path.name for path in out.iterdir()} == {"cut", NASTY}
    assert list((out / NASTY).iterdir()) == []
