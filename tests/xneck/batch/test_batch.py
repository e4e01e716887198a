"""A batch ends whatever its recordings and workers do, does nothing twice, and comes to the same on another machine."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import psutil
import pytest
from playwright.sync_api import Page

import xneck.batch.run_batch
import xneck.recording.fingerprint
import xneck.batch.recording_task
from samples.generator.hidden.experiment import hide
from tests.command import Ran, run
from tests.html_page import Elements, check_print, look, watch
from tests.paths import SAMPLES
from xneck.recording.fingerprint import fingerprint, refreshed_if_unchanged
from xneck.recording.recording_folder import read_recording
from xneck.recording.result_folder import remove_results, stored_result, remove_partial_files
from xneck.batch.recording_task import run_recording_task
from xneck.report.number_text import number_text, with_sigma
from xneck_foundation.errors import Refused
from xneck_foundation.recovery import warn_recovered
from xneck_foundation.whole_file import whole_file

HELD_OUT = SAMPLES / "held_out"
NASTY = "<script>alert(1)<b> 100%20 & #1 'b' \"é雪"
FRAMES = 270
"""9 s of the sample"""
XNECK = [sys.executable, "-c", "from xneck.cli import main; main()"]


def cut_short(folder: Path) -> None:
    """The start of the sample, its log cut off in the middle."""
    shutil.copytree(HELD_OUT, folder)
    rows = (HELD_OUT / "angles.csv").read_text().splitlines()
    (folder / "angles.csv").write_text("\n".join(rows[: FRAMES + 1]) + "\n")
    whole = (HELD_OUT / "log.mcap").read_bytes()
    (folder / "log.mcap").write_bytes(whole[: len(whole) * 5 // 8])


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """One with a name that tries to be markup, one whose log lacks a column, one cut off, one without a recording.yaml."""
    home = tmp_path_factory.mktemp("recordings")
    hide((), 1, home, seconds=(9.0, 9.0))
    (home / "truth.json").unlink()
    (home / "fitted").rename(home / NASTY)
    (home / "held_out").rename(home / "broken")
    log = home / "broken/log.csv"
    log.write_text(log.read_text().replace("f3", "g3", 1))
    cut_short(home / "cut")
    (home / "empty").mkdir()
    return sorted(home.iterdir())


def worker_of(command: int) -> int | None:
    """The process in which a command's tasks run."""
    for process in psutil.Process(command).children(recursive=True):
        if "spawn_main" in " ".join(process.cmdline()):
            return process.pid
    return None


@pytest.fixture(scope="module")
def batch(recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Ran]:
    """All by one worker, which is killed once in the middle of the first."""
    out = tmp_path_factory.mktemp("results")
    (out / NASTY).mkdir()
    (out / NASTY / ".report.xneck-0a1b2c3d.html").write_text("what an earlier kill left")
    (out / NASTY / "notes.txt").write_text("a person's own")
    words = [*XNECK, "run", *map(str, recordings), "--out", str(out), "--jobs", "1"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as command:
        while not (out / NASTY / "dataset.mcap").exists() and command.poll() is None:
            time.sleep(0.02)
        victim = worker_of(command.pid)
        assert victim is not None
        os.kill(victim, signal.SIGKILL)
        printed, said = command.communicate()
    return out, Ran(command.returncode, printed, said)


def test_it_ends_with_all_results_and_the_failures_by_name(batch: tuple[Path, Ran]) -> None:
    out, ran = batch
    assert ran.status == 1
    lines = {name: line for line in ran.out.splitlines() for name in (NASTY, "broken", "cut", "empty") if name in line}
    assert re.search(r"\d+ of \d+ .* s ± .* ms .*consistent .*fs", lines[NASTY])
    assert "failed: log.csv: lacks the column f3" in lines["broken"]
    assert re.search(f"{FRAMES} of {FRAMES} .*log.mcap: is cut off; /joint_states has", lines["cut"])
    assert "failed: has no recording.yaml; " in lines["empty"]
    assert "4 recordings: 2 done, 2 failed; 0 of them known from before" in ran.out
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


def test_what_a_killed_writer_left_goes_with_the_results(tmp_path: Path) -> None:
    """A part as whole_file itself makes it, of every output; what the writer still holds stays, and a person's own files."""
    for name in ("dataset.mcap", "report.html"):
        with whole_file(tmp_path / name) as part:
            left = part.with_name(part.name[: -len(part.suffix) - 8] + "0a1b2c3d" + part.suffix)
            shutil.copy(part, left)
            remove_partial_files(tmp_path)
            assert part.exists()
            assert not left.exists()
    (tmp_path / ".report-of-mine.html").touch()
    remove_results(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".report-of-mine.html"]


@contextmanager
def idle(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Where nothing is run: the names of what would be."""
    asked: list[str] = []

    def instead(left: dict[str, Any], *_: Any) -> Iterator[Any]:
        asked.extend(left)
        yield from (xneck.batch.run_batch.Ended(name, None, "not run", before=False) for name in left)

    with monkeypatch.context() as patch:
        patch.setattr(xneck.batch.run_batch, "_spread", instead)
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
    assert set(told["failed"]) == {"broken", "empty"}
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
    monkeypatch.setattr(xneck.recording.fingerprint, "digest", lambda *_: "other sources")
    assert redone() == [NASTY, "broken", "cut"]
    monkeypatch.undo()
    assert redone("--redo") == [NASTY, "broken", "cut"]


def test_a_hash_is_taken_only_where_a_time_differs(recordings: list[Path], monkeypatch: pytest.MonkeyPatch) -> None:
    recording = read_recording(next(path for path in recordings if path.name == "cut"))
    origin = fingerprint(recording)
    read: list[Path] = []
    monkeypatch.setattr(xneck.recording.fingerprint, "sha256", lambda path: read.append(path) or "another")
    assert refreshed_if_unchanged(origin, recording) == origin
    assert read == []
    later = json.loads(json.dumps(origin))
    later["inputs"]["log"]["mtime_ns"] -= 1
    assert refreshed_if_unchanged(later, recording) is None
    assert read == [recording.log]


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
    with subprocess.Popen(scheduler, **options) as first, subprocess.Popen(worker, **options) as second:
        while not note.exists():
            assert first.poll() is None
            time.sleep(0.05)
        address = json.loads(note.read_text())["address"]
        from distributed import Client

        with Client(address) as client:
            client.wait_for_workers(1)
        yield address
        second.terminate()
        first.terminate()


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
        assert here == there
    refused = [json.loads((folder / "broken/refused.json").read_text()) for folder in (out, tmp_path)]
    assert refused[0] == refused[1]


def test_the_page_says_what_summary_json_says(batch: tuple[Path, Ran]) -> None:
    out, _ = batch
    text = (out / "summary.html").read_text(encoding="utf-8")
    assert NASTY not in text
    elements = Elements(text)
    links = [str(attributes["href"]) for tag, attributes in elements.tags if tag == "a"]
    ids = {attributes.get("id") for _, attributes in elements.tags}
    assert {link[1:] for link in links if link.startswith("#")} == {"recordings", "failed", "lost", "parameters"} <= ids
    reports = [link for link in links if not link.startswith("#")]
    assert [(out / unquote(link)).resolve() for link in reports] == [
        out / name / "report.html" for name in (NASTY, "cut")
    ]
    assert all((out / unquote(link)).is_file() for link in reports)
    assert NASTY in elements.text
    for name, row in json.loads((out / "summary.json").read_text())["recordings"].items():
        if row["failure"]:
            assert f"{name}: {row['failure']}" in elements.text
            continue
        assert f"{row['frames_used']} of {row['frames']}" in elements.text
        assert f"{number_text(row['offset_s'], 5)} s ± " in elements.text
        for p in row["parameters"]:
            assert not p["identified"] or with_sigma(p["value"], p["sigma"]) in elements.text


@pytest.mark.parametrize("width", [360, 1280])
def test_a_browser_shows_it(browser_page: Page, batch: tuple[Path, Ran], width: int) -> None:
    look(browser_page, batch[0] / "summary.html", width)


def test_printed_nothing_is_cut_off(browser_page: Page, batch: tuple[Path, Ran]) -> None:
    check_print(browser_page, batch[0] / "summary.html")


def test_from_the_summary_to_each_report_and_back(browser_page: Page, batch: tuple[Path, Ran]) -> None:
    summary, watched = batch[0] / "summary.html", watch(browser_page)
    reports = {name: batch[0] / name / "report.html" for name in (NASTY, "cut")}
    browser_page.goto(summary.as_uri())
    for name, report in reports.items():
        browser_page.get_by_role("link", name=name, exact=True).click()
        browser_page.wait_for_url(report.as_uri())
        assert browser_page.title() == f"{name}: xneck report"
        assert browser_page.locator("h1").inner_text() == name
        browser_page.go_back()
        browser_page.wait_for_url(summary.as_uri())
    watched.check([summary, *reports.values()])


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
    assert re.fullmatch(r"cut: 270 of 270 frames, offset .*report\.html \(done before\)\n", ran.out)
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

    monkeypatch.setattr(xneck.batch.run_batch, "workers", no_workers)
    monkeypatch.setattr(xneck.batch.run_batch, "spread", interrupted)
    ran = run(capfd, "run", *recordings, "--out", out, "--redo")
    assert (ran.status, ran.out) == (130, "")
    assert {path.name: path.read_bytes() for path in (out / "cut").iterdir()} == whole
    assert {path.name for path in out.iterdir()} == {"cut", NASTY}
    assert list((out / NASTY).iterdir()) == []


def test_recordings_in_one_process_hear_their_own_warnings(
    recordings: list[Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a worker with several threads: warnings go to whoever listens last."""
    recording = read_recording(next(path for path in recordings if path.name == "cut"))

    def stages(_: Any, folder: Path, __: Any) -> None:
        time.sleep(0.1)
        warn_recovered(folder.name, "is cut off")
        time.sleep(0.1)
        raise Refused("here", "stop")

    monkeypatch.setattr(xneck.batch.recording_task, "run_recording", stages)
    with ThreadPoolExecutor(2) as threads:
        ended = {name: threads.submit(run_recording_task, recording, tmp_path / name) for name in ("a", "b")}
    assert {name: str(one.exception()) for name, one in ended.items()} == {
        name: f"here: stop ({name}: is cut off)" for name in ("a", "b")
    }
    assert {path.parent.name for path in tmp_path.glob("*/refused.json")} == {"a", "b"}
