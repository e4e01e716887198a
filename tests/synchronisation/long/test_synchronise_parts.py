"""A recording that is synchronised part by part is the one that it is as a whole, and as the world made it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.long_recordings import chain
from identification.dataset import stretches
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from mechanism.description import read_neck
from samples.generator.prescribed import World, prescribe
from samples.worlds.clock_worlds import NECK_FILE, NOISE_RAD
from synchronisation.angles import Angles
from synchronisation.long import parts_clock
from synchronisation.long import synchronise_parts as module
from synchronisation.long.synchronise_parts import synchronise_parts
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import parse_yaml

TURN_S, TURNS, SEED = 20.0, 3, 7
NECK = read_neck(NECK_FILE)
WORLD = World(parse_yaml(NECK_FILE.read_text(), "neck.yaml"))


@pytest.fixture(scope="module", autouse=True)
def short_parts() -> Iterator[None]:
    """Parts of 20 s, so that a minute is long."""
    with pytest.MonkeyPatch.context() as patch:
        for place in (parts_clock, module):
            patch.setattr(
                place, "consecutive_spans", lambda first, last: stretches.consecutive_spans(first, last, 20.0)
            )
        yield


@pytest.fixture(scope="module")
def recording() -> tuple[Angles, Series]:
    return chain(WORLD, TURN_S, TURNS, SEED, NOISE_RAD)


@pytest.fixture(scope="module")
def whole(recording: tuple[Angles, Series]) -> DataSet:
    return synchronise(NECK, NECK_FILE.read_text(), *recording, {})


def in_parts(angles: Angles, log: Series, folder: Path) -> DataSet:
    return synchronise_parts(NECK, NECK_FILE.read_text(), angles, log, {}, folder)


@pytest.fixture(scope="module")
def parts(recording: tuple[Angles, Series], tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """The recording, synchronised part by part."""
    return in_parts(*recording, tmp_path_factory.mktemp("parts"))


def test_rows_and_clock_are_those_of_the_whole(parts: DataSet, whole: DataSet) -> None:
    assert parts.clock["parts"] == 3
    for topic in ("state", "fasquelle"):
        assert np.array_equal(getattr(parts, topic).time, getattr(whole, topic).time)
    sigma = np.hypot(parts.clock["offset_sigma_s"], whole.clock["offset_sigma_s"])
    assert abs(parts.clock["offset_s"] - whole.clock["offset_s"]) < 3 * sigma
    # what all parts have in common does not average out
    assert parts.clock["offset_sigma_s"] >= 0.9 * whole.clock["offset_sigma_s"]
    assert parts.check["verdict"] == whole.check["verdict"] == "consistent"
    # what no clock enters: Fasquelle's filters have settled at the seams
    for name in ("theta2_dd", "f1"):
        a, b = parts.fasquelle.columns[name], whole.fasquelle.columns[name]
        assert np.max(np.abs(a - b)) < 1e-6 * np.std(b)


def test_the_state_errs_as_its_sigma_says(recording: tuple[Angles, Series], parts: DataSet) -> None:
    """Against the world's truth, seams and all: rms over sigma of N x 3 numbers that are correlated over seconds."""
    made, begin, time = [prescribe(WORLD, TURN_S, [SEED, turn]) for turn in range(TURNS)], 0.0, []
    for one in made:
        time.append(one.log_time - one.log_time[0] + begin)
        begin += 0.002 * len(one.log_time)
    truth_time = np.concatenate(time) + recording[1].time[0]
    seen = ~np.any(parts.state.matrix("bridged") > 0, axis=1)
    for suffix, name in (("", "alpha"), ("_d", "alpha_d"), ("_dd", "alpha_dd")):
        truth = np.concatenate([getattr(one, name) for one in made])
        at_rows = np.stack([np.interp(parts.state.time, truth_time, column) for column in truth.T], axis=-1)
        error = (parts.state.matrix("alpha", suffix) - at_rows)[seen]
        sigma = parts.state.matrix("sigma_alpha", suffix)[seen]
        # a constant of 4 cables' laws in 3 parts: some ten independent numbers, of which the mean square stays below 2.25
        # with 98 %
        assert np.sqrt(np.mean((error / sigma) ** 2)) < 1.5, suffix


def test_frames_lost_at_a_seam_and_within_a_part_are_found(
    recording: tuple[Angles, Series], parts: DataSet, tmp_path: Path
) -> None:
    angles, log = recording
    period = float(np.median(np.diff(angles.time)))
    late = angles.time > angles.time[0] + 30.0
    stamped = replace(angles, time=angles.time - 2 * period * late)
    # the frames that were lost are not there either
    first = int(np.argmax(late))
    keep = np.ones(len(angles.time), dtype=bool)
    keep[first : first + 2] = False
    stamped = replace(
        stamped, time=stamped.time[keep], alpha=stamped.alpha[keep], sigma=stamped.sigma[keep], light=None, common=None
    )
    found = in_parts(stamped, log, tmp_path)
    assert found.clock["frames_lost"] == 2
    for clock in (found.clock, parts.clock):
        assert clock["offset_sigma_s"] < 1e-3
    last = 2 * period + found.clock["offset_s"], parts.clock["offset_s"]
    assert found.clock["skew_ppm"] == pytest.approx(parts.clock["skew_ppm"], abs=20)
    assert last[0] - 2 * period == pytest.approx(last[1], abs=1e-3)


def test_a_part_that_contradicts_is_named(recording: tuple[Angles, Series], tmp_path: Path) -> None:
    angles, log = recording
    theta = log.columns["theta2"].copy()
    stuck = log.time > log.time[-1] - 18
    theta[stuck] = theta[stuck][0]
    with pytest.raises(Refused, match=r"s of the video: .*theta2"):
        in_parts(angles, Series(log.time, {**log.columns, "theta2": theta}), tmp_path)


def test_an_arm_that_rests_for_a_part_has_a_clock(
    recording: tuple[Angles, Series], parts: DataSet, tmp_path: Path
) -> None:
    """A rest of 25 s after a minute of motion: no part of it has a clock of its own."""
    angles, log = recording
    rest_rows, frame = round(40 / 0.002), float(np.median(np.diff(angles.time)))
    rest_frames = round(39 / frame)
    time = np.concatenate([log.time, log.time[-1] + 0.002 * np.arange(1, rest_rows + 1)])
    longer = Series(time, {n: np.concatenate([c, np.full(rest_rows, c[-1])]) for n, c in log.columns.items()})
    rng = np.random.default_rng(0)
    still = angles.alpha[-1] * 0 + rng.normal(0, NOISE_RAD, (rest_frames, 3))
    resting = replace(
        angles,
        time=np.concatenate([angles.time, angles.time[-1] + frame * np.arange(1, rest_frames + 1)]),
        alpha=np.concatenate([angles.alpha, still]),
        sigma=np.concatenate([angles.sigma, np.full_like(still, NOISE_RAD)]),
    )
    rested = in_parts(resting, longer, tmp_path)
    assert any("too little motion" in warning for warning in rested.clock["warnings"])
    assert rested.clock["offset_s"] == pytest.approx(parts.clock["offset_s"], abs=5e-4)
