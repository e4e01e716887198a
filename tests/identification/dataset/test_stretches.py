"""A data set in parts has every row once; stretches of one are read alone, and share their errors honestly."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification.dataset import stretches as module
from identification.dataset.columns_on_disk import SeriesOnDisk
from identification.dataset.dataset import DataSet, state_series
from identification.dataset.dataset_file import EDGE_S, read_dataset, write_dataset
from identification.dataset.series import Series, numbered_columns
from identification.dataset.stretches import (
    Stretches,
    chosen_stretches,
    consecutive_spans,
    parts_of,
    read_stretches,
    state_span,
)
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

SECONDS, OFFSET_S = 80.01, 1.5


def thrice(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for a signal and its derivatives: only the file is at stake here."""
    return values, values, values


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of 80 s at 100 Hz, whose quarters end on rows; its log goes on for 20 s, its frames have a clock of their own."""
    neck = read_neck(NECK_FILE)
    t = 0.01 * np.arange(round(SECONDS / 0.01), dtype=float) + 7
    long = 0.01 * np.arange(round((SECONDS + 20) / 0.01), dtype=float) + 7
    alpha, theta = 0.2 * np.sin(np.outer(t, [1.0, 2.0, 3.0])), np.sin(np.outer(t, [1.0, 2.0, 3.0, 4.0]))
    motors = np.sin(np.outer(long, [1.0, 2.0, 3.0, 4.0]))
    state = state_series(arm_of(neck), t, thrice(alpha), thrice(theta), 40 + theta, thrice(0.01 + alpha**2))
    columns = numbered_columns("alpha", alpha[::3]) | numbered_columns("sigma", np.full_like(alpha[::3], 2e-3))
    angles = Series(t[::3] - OFFSET_S, columns | numbered_columns("common", np.full_like(alpha[::3], 1e-3)))
    log = Series(long, numbered_columns("theta", motors) | numbered_columns("f", 40 + motors))
    clock = {"offset_s": OFFSET_S, "offset_sigma_s": 3e-5, "skew_sigma_ppm": 1.0, "camera_middle_s": 50.5}
    path = tmp_path_factory.mktemp("long") / "d.mcap"
    write_dataset(
        DataSet(
            neck=neck,
            neck_yaml=NECK_FILE.read_text(),
            state=state,
            fasquelle=state.part(slice(None, None, 3)),
            angles=angles,
            log=log,
            clock=clock,
        ),
        path,
    )
    return path


@pytest.fixture
def short_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts of 20 s, so that a minute and a half is long."""
    monkeypatch.setattr(module, "consecutive_spans", lambda first, last: consecutive_spans(first, last, 20.0))


@pytest.mark.usefixtures("short_parts")
@pytest.mark.parametrize("window", [0.0, 0.5])
def test_every_row_is_in_one_part(file: Path, window: float) -> None:
    whole, parts = read_dataset(file), list(parts_of(file, window=window))
    assert len(parts) == 4
    for topic in ("state", "fasquelle"):
        time = np.concatenate([getattr(part, topic).time for part in parts])
        assert np.array_equal(time, getattr(whole, topic).time)
    x = np.concatenate([part.state.columns["x2"] for part in parts])
    assert np.array_equal(x, whole.state.columns["x2"])
    if window:
        assert {len(part.state) % 50 for part in parts[:-1]} == {0}


@pytest.mark.usefixtures("short_parts")
def test_a_part_has_frames_and_log_around_its_rows_and_no_more(file: Path) -> None:
    for part in parts_of(file):
        first, last = part.state.time[[0, -1]]
        for time in (part.log.time, part.angles.time + OFFSET_S):
            assert first - EDGE_S - 1e-6 <= time[0] <= max(first - EDGE_S + 0.04, 7.0)
            assert last < time[-1] + 0.04
            assert time[-1] <= last + EDGE_S + 0.02


def test_the_span_of_the_state_is_known_without_reading_it(file: Path) -> None:
    assert state_span(file) == pytest.approx((7.0, 7.0 + SECONDS - 0.01), abs=1e-9)


def test_a_short_recording_is_judged_whole(file: Path) -> None:
    (one,) = chosen_stretches([file], 100.0, 3, 300.0)
    assert one.whole
    assert np.array_equal(read_stretches(file, one)[0].state.time, read_dataset(file).state.time)


def test_stretches_are_spread_over_a_long_one_and_named(file: Path) -> None:
    (one,) = chosen_stretches([file], 60.0, 2, 300.0)
    assert not one.whole
    assert [last - first for first, last in one.spans] == pytest.approx([30.0, 30.0])
    assert one.spans[0][0] < 7 + 2 * EDGE_S
    assert one.spans[1][1] > 7 + SECONDS - 2 * EDGE_S
    assert one.record["seconds"] == pytest.approx(SECONDS, abs=0.02)
    for data, (first, last) in zip(read_stretches(file, one), one.spans, strict=True):
        assert data.state.time[[0, -1]] == pytest.approx([first, last], abs=0.011)


def test_many_recordings_have_less_each_and_too_many_are_refused(file: Path) -> None:
    assert all(len(one.spans) == 2 for one in chosen_stretches([file] * 5, 80.0, 4, 200.0))
    with pytest.raises(Refused, match=r"11 recordings are more than are held at once \(10\)"):
        chosen_stretches([file] * 11, 80.0, 4, 200.0)


def test_a_shared_error_is_no_smaller_by_cutting(file: Path) -> None:
    """Any weighted mean of stretches has at least the variance of the error that they share."""
    whole = read_dataset(file)
    (chosen,) = chosen_stretches([file], 60.0, 3, 300.0)
    parts = read_stretches(file, chosen)
    clock = np.array([part.clock["offset_sigma_s"] for part in parts])
    common = np.array([part.angles.columns["common1"][0] for part in parts])
    rng = np.random.default_rng(0)
    for weight in rng.dirichlet([1.0] * 3, 50):
        assert np.sqrt(np.sum((weight * clock) ** 2)) >= whole.clock["offset_sigma_s"]
        assert np.sqrt(np.sum((weight * common) ** 2)) >= 1e-3 * (1 - 1e-9)
    white = np.sqrt(parts[0].angles.columns["sigma1"] ** 2 - parts[0].angles.columns["common1"] ** 2)
    assert white == pytest.approx(np.sqrt(3) * 1e-3)  # noise from frame to frame is each one's own
    away = abs(np.mean(parts[0].state.time[[0, -1]]) - 52.0)
    assert clock[0] == pytest.approx(np.sqrt(3) * np.hypot(3e-5, 1e-6 * away), rel=1e-3)


def test_a_large_file_without_its_index_is_refused(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[:-5000])
    assert state_span(cut) is None
    assert Stretches(((-np.inf, np.inf),), np.inf).whole
    monkeypatch.setattr(module, "MAX_BYTES_WITHOUT_INDEX", 1000)
    with pytest.raises(Refused, match="lost the index"):
        state_span(cut)


def test_a_series_on_disk_is_written_as_one_in_memory(file: Path, tmp_path: Path) -> None:
    whole = read_dataset(file)
    held = SeriesOnDisk(tmp_path, 20_000)
    for begin in range(0, len(whole.state), 2500):
        held.write(whole.state.part(slice(begin, begin + 2500)))
    write_dataset(replace(whole, state=held.series()), tmp_path / "copy.mcap")
    assert (tmp_path / "copy.mcap").read_bytes() == file.read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["copy.mcap"]
