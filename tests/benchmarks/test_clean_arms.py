"""The record of an arm is what its truth says, and the table is what the records say."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from benchmarks.clean_arms import COLUMNS, clock_record, judged, runs_in, state_errors, table
from benchmarks.forward_arm_runs import SETTINGS, SeenArm, seen
from identification.estimates import estimate
from samples.forward_arms.arms import make_arms
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import write_text

SHORT = replace(SETTINGS, seconds=10.0, offset=(-0.3, 0.3))
NOISE_DEG = 0.02


@dataclass(frozen=True)
class Read:
    """An arm and its record."""

    arm: SeenArm
    record: dict[str, Any]


@pytest.fixture(scope="module")
def read() -> Read:
    (arm,) = (seen(arm, SHORT, NOISE_DEG) for arm in make_arms([41], SHORT))
    return Read(arm, judged(arm))


def test_nothing_is_hidden_and_nothing_is_named(read: Read) -> None:
    """Held out, what 10 s left uncertain of the numbers, up to twice the noise, is in the floor; their errors may be none."""
    record = read.record
    assert record["verdict"] in ("consistent", "insufficient")
    assert record["causes"] == record["sets"] == []
    over = [*record["motors_over_floor"], *record["joints_over_floor"]]
    assert len(record["motors_over_floor"]) == 4
    assert 0.8 < min(over) < max(over) < 1.25
    held_out = record["held_out_over_floor"]
    assert list(held_out) == ["motor equations", "arm equations"]
    for before, after in held_out.values():
        assert before == after
        assert 0.9 / np.sqrt(1 + 2**2) < before < 1.25


def test_errors_of_parameters_are_from_the_true_plant(read: Read) -> None:
    plant = read.arm.arm.plant
    estimates = estimate([read.arm.synchronised(0)])
    values = {(p.name, p.index): p.value for p in estimates.parameters}
    truth = {"fs": plant.dry, "k": plant.stiffness, "ca": plant.damping, "x0": plant.x0}
    parameters = read.record["parameters"]
    assert {(p["name"], p["index"]) for p in parameters} == {(name, j) for name in truth for j in (1, 2, 3, 4)}
    for p in parameters:
        true = float(truth[p["name"]][p["index"] - 1])
        assert values[p["name"], p["index"]] - p["error"] == pytest.approx(true)
        assert p["z"] == pytest.approx(p["error"] / p["sigma"])
        assert p["covered"] == (abs(p["z"]) <= 1.96)
        if p["name"] in ("fs", "k", "x0"):
            assert abs(p["error"]) < 0.05 * true


def test_errors_of_the_clock_are_from_the_true_one(read: Read) -> None:
    data, film = read.arm.synchronised(1), read.arm.films[1]
    assert abs(read.record["clocks"][1]["error_ms"]) < 0.3
    moved = replace(film, offset=film.offset - 0.005)
    more = clock_record(data, moved)["error_ms"] - read.record["clocks"][1]["error_ms"]
    assert more == pytest.approx(5.0)


def test_errors_of_the_state_are_from_the_true_motion(read: Read) -> None:
    """The truth between its steps by its own slopes; a motion that is 2 ms late is noticed."""
    data, truth = read.arm.synchronised(0), read.arm.arm.recordings[0].truth
    e, covariance = state_errors(data, truth)
    assert data.covariance is not None
    at = data.covariance.time
    assert covariance.shape == (len(at), 9, 9)
    np.testing.assert_array_equal(covariance, np.swapaxes(covariance, 1, 2))
    assert np.linalg.eigvalsh(covariance).min() > 0
    alpha = CubicHermiteSpline(truth.time, truth.alpha, truth.alpha_d)
    rows = np.searchsorted(data.state.time, at - 1e-6)
    np.testing.assert_allclose(e[:, :3], data.state.matrix("alpha")[rows] - alpha(at), atol=1e-9)
    late = replace(truth, time=truth.time + 0.002)
    assert np.sqrt(np.mean(state_errors(data, late)[0][:, :3] ** 2)) > 3 * np.sqrt(np.mean(e[:, :3] ** 2))
    assert 0.5 < read.record["states"][0]["nees"][0] < 2


def test_the_table_is_what_records_say(read: Read, tmp_path: Path) -> None:
    """Of two arms, one refused; another noise has no row."""
    runs = runs_in(tmp_path, (1002, 1003), (NOISE_DEG, 0.1))
    heading: dict[str, Any] = {"seed": 1002, "source": "abc"}
    clean: dict[str, Any] = {**heading, **read.record, "verdict": "consistent"}
    for seed, record in ((1002, clean), (1003, heading | {"refused": "no motion"})):
        write_text(runs.file(runs.scenes[0], seed, NOISE_DEG), json_text(record))
    shown = table(runs)
    assert [label for label, _ in shown.rows] == ["0.02 deg"]
    row = dict(zip(COLUMNS, shown.rows[0][1], strict=True))
    assert row["consistent %"] == 50
    assert (row["from %"], row["to %"]) == pytest.approx((1.258, 98.742), abs=1e-3)
    assert row["arms"] == 2
    assert row["clock ms"] == pytest.approx(np.hypot(*(c["error_ms"] for c in clean["clocks"])) / np.sqrt(2))
    assert row["covered %"] == pytest.approx(100 * np.mean([p["covered"] for p in clean["parameters"]]))
    assert shown.notes == ("Runs by digest of the sources: 2 by abc.",)
