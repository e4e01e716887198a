"""What Rerun reads back from the .rrd is what was found, each at its time on the log's clock."""

import os
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

from identification.dataset.clock_record import log_time
from mechanism.cable_lengths import lengths
from mechanism.description import Neck
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.linkage import solve
from samples.generator.video import tag_as_turned
from tests.command import run
from tests.vision.test_video import film
from tests.xneck.viewers.recording_result import HIDDEN, motion, result
from vision.video import read_frames
from xneck.recording.recording_result import RecordingResult
from xneck.viewers.rerun_file import time_column, write_rerun
from xneck.viewers.viewer_video import viewer_video

CODED = 1.0
"""grey levels by which coding may move a flat picture's mean: less than half of what frames differ by"""
SHOWN_PX = 1e-3
"""px: single precision of a picture's width, and of the fit to exact corners"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> RecordingResult:
    return result(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def read(made: RecordingResult, tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """Of each entity its components as lists, and `time`, s."""
    pytest.importorskip("rerun", reason="the extra `rerun` is not installed")
    from rerun.chunk import RrdReader  # type: ignore[import-not-found]

    path = tmp_path_factory.mktemp("rrd") / "recording.rrd"
    write_rerun(made, path)
    found: dict[str, dict[str, Any]] = {}
    for chunk in RrdReader(path).stream():
        batch, parts = chunk.to_record_batch(), found.setdefault(chunk.entity_path, {})
        assert chunk.is_static or chunk.timeline_names == ["time"], "one time axis"
        for name in batch.schema.names:
            column = batch.column(name)
            parts[name] = (
                column.to_numpy(zero_copy_only=False).astype(float) / 1e9 if name == "time" else column.to_pylist()
            )
    return found


def flat(picture: np.ndarray) -> float:
    """Mean grey level of a film's frame below its rows of noise."""
    return float(picture[16:64, :96].mean())


def pairs(below: np.ndarray, above: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Ends of diagonals, from each bar's one end to the other end of the next."""
    return list(zip(below[:-1], above[1:], strict=True))


def scalars(part: dict[str, Any]) -> np.ndarray:
    return np.array([row[0] for row in part["Scalars:scalars"]])


def test_curves_are_the_data_sets_columns_to_the_last_bit(
    made: RecordingResult, read: dict[str, dict[str, Any]]
) -> None:
    state = made.data.state
    for stem, count in (("alpha", 3), ("theta", 4), ("x", 4), ("f", 4)):
        for k in range(1, count + 1):
            part = read[f"/state/{stem}{k}"]
            np.testing.assert_array_equal(scalars(part), state.columns[f"{stem}{k}"])
            np.testing.assert_allclose(part["time"], state.time, atol=1e-9)
    for k in range(1, 4):
        alpha, sigma = state.columns[f"alpha{k}"], state.columns[f"sigma_alpha{k}"]
        np.testing.assert_array_equal(scalars(read[f"/state_band/alpha{k}_high"]), alpha + 2 * sigma)
        np.testing.assert_array_equal(scalars(read[f"/state_band/alpha{k}_low"]), alpha - 2 * sigma)
    length = lengths(made.data.arm, state.matrix("alpha"))
    np.testing.assert_array_equal(scalars(read["/model/length4"]), length[:, 3])
    np.testing.assert_array_equal(scalars(read["/simulated/tension2"]), state.columns["f2"])


def test_frames_lie_on_the_state_at_their_time(made: RecordingResult, read: dict[str, dict[str, Any]]) -> None:
    """Noise of 1 mrad, of which 4 sigma are allowed; a clock that is off by a frame would leave 30 times as much."""
    for k in range(1, 4):
        part = read[f"/angles/alpha{k}"]
        error = scalars(part) - motion(part["time"] - 3.0)[:, k - 1]
        assert np.nanmax(np.abs(error)) < 4e-3
        assert np.isnan(error).sum() == HIDDEN.stop - HIDDEN.start
        np.testing.assert_allclose(scalars(read[f"/away/alpha{k}"]), error, atol=1e-5)


def test_every_frame_of_the_video_is_shown_at_its_time(made: RecordingResult, read: dict[str, dict[str, Any]]) -> None:
    """Frames follow each other by more than twice what coding changes: each reference leads to the picture of its own frame."""
    video = read["/video"]
    np.testing.assert_allclose(video["time"], log_time(made.data.clock, made.data.angles.time), atol=1e-9)
    ((blob,),) = video["AssetVideo:blob"]
    with av.open(BytesIO(bytes(blob)), "r") as container:
        shown = {round(1e9 * p.time): flat(p.to_ndarray()) for p in container.decode(video=0) if p.time is not None}
    levels = [shown[row[0]] for row in video["VideoFrameReference:timestamp"]]
    assert made.recording.video is not None
    expected = [flat(frame.grey) for frame in read_frames(made.recording.video)]
    assert np.min(np.abs(np.diff(expected))) > 2 * CODED
    np.testing.assert_allclose(levels, expected, atol=CODED)


def test_lines_over_the_video_are_where_another_linkage_and_camera_put_them(
    made: RecordingResult, read: dict[str, dict[str, Any]]
) -> None:
    neck: Neck = made.data.neck
    assert made.video is not None
    markers, linkage = (read[f"/video/{name}"]["LineStrips2D:strips"] for name in ("markers", "linkage"))
    alpha = motion(read["/video/linkage"]["time"] - 3.0)
    bars = solve(alpha, np.array([m.L for m in neck.mechanisms]), np.array([m.b for m in neck.mechanisms]))
    for index in range(len(alpha)):
        if HIDDEN.start <= index < HIDDEN.stop:
            assert markers[index] == linkage[index] == []
            continue
        np.testing.assert_allclose(np.array(markers[index])[:, :4], made.video.extraction.corners[index], atol=SHOWN_PX)
        ends = np.stack([bars.left[index], bars.right[index]], axis=-1)
        expected = SAMPLE_CAMERA.project(np.stack([np.real(ends), np.imag(ends)], axis=-1))
        left, right = expected[:, 0], expected[:, 1]
        lines = [*zip(left, right, strict=True), *pairs(left, right), *pairs(right, left)]
        np.testing.assert_allclose(np.array(linkage[index])[:, [0, -1]], np.array(lines), atol=SHOWN_PX)


def test_the_layout_shows_every_curve_of_the_file(
    made: RecordingResult, tmp_path: Path, read: dict[str, dict[str, Any]]
) -> None:
    from rerun.chunk import RrdReader  # type: ignore[import-not-found]

    write_rerun(made, tmp_path / "a.rrd")
    file = RrdReader(tmp_path / "a.rrd")
    contents: list[str] = []
    for store in file.blueprints():
        for chunk in file.stream(store=store):
            batch = chunk.to_record_batch()
            if "ViewContents:query" in batch.schema.names:
                contents += [line for row in batch.column("ViewContents:query").to_pylist() for line in row]
    curves = {line.removeprefix("+ ") for line in contents if "**" not in line}
    assert curves == {entity for entity, parts in read.items() if "Scalars:scalars" in parts}


def test_a_clock_that_counts_from_1970_is_shown_as_a_date() -> None:
    rr = pytest.importorskip("rerun", reason="the extra `rerun` is not installed")
    assert str(time_column(rr, np.array([1.7e9, 1.7e9 + 1])).times.type) == "timestamp[ns]"
    assert str(time_column(rr, np.array([3.0, 4.0])).times.type) == "duration[ns]"


def test_a_turned_video_is_played_upright(tmp_path: Path) -> None:
    """What was the top row, coded noise, stands at the right."""
    turned = film(tmp_path / "turned.mp4", [3000 * k for k in range(5)])
    tag_as_turned(turned)
    (tmp_path / "playable.mp4").write_bytes(viewer_video(turned))
    before, after = (next(read_frames(path)).grey.astype(float) for path in (turned, tmp_path / "playable.mp4"))
    assert after.shape == before.shape == (96, 64)
    assert np.abs(after[:, :48] - before[:, :48]).mean() < CODED
    assert after[:, 56:].std() > 10 * after[:, :48].std()


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="this system has no scheduling policies")
def test_the_encoder_does_not_put_this_process_before_all_others(tmp_path: Path) -> None:
    """As root it puts itself and its caller under real-time scheduling: Chromium, started later, took whole machines."""
    before = os.sched_getscheduler(0)
    viewer_video(film(tmp_path / "film.mp4", [3000 * k for k in range(5)]))
    assert {os.sched_getscheduler(int(thread.name)) for thread in Path("/proc/self/task").iterdir()} == {before}


def test_without_the_extra_one_line_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    ran = run(capfd, "run", tmp_path, "--rerun")
    assert ran.status == 1
    assert "pip install 'xneck[rerun]'" in ran.err
    assert len(ran.err.splitlines()) == 1
