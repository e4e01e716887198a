"""Joints told by motors alone, on arms of a generator that shares no code with the observer, their drawings off."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series
from observation.observed_log import observe_log
from observation.observer import Observer
from tests.observation.arms import NOISE_RAD, SEEDS, SETTLED, Case, case, unexplained
from xneck_foundation.errors import Refused

ROWS = 3000


def part(of: Case, rows: int = ROWS) -> Series:
    return of.log.part(slice(0, rows))


def errors(of: Case, seen: Series) -> tuple[np.ndarray, np.ndarray]:
    """Of angles and rates once settled."""
    judged = slice(SETTLED, len(seen))
    return (seen.matrix("alpha") - of.alpha[: len(seen)])[judged], (
        seen.matrix("alpha", "_d") - of.alpha_d[: len(seen)]
    )[judged]


@pytest.mark.parametrize("seed", SEEDS)
def test_joints_are_within_a_tenth_of_a_degree_and_rates_within_a_degree_and_a_half_a_second(seed: int) -> None:
    of = case(seed)
    seen = observe_log(of.neck, of.model, part(of)).series
    angle, rate = errors(of, seen)
    assert np.degrees(np.sqrt(np.mean(angle**2, axis=0))).max() < 0.1
    assert np.degrees(np.sqrt(np.mean(rate**2, axis=0))).max() < 1.5
    # errors of angles are those of two numbers of each joint all along: mean squares of six are below 3.3 in 997 of 1000
    for stem, error in (("", angle), ("_d", rate)):
        sigma = seen.matrix("sigma_alpha", stem)[SETTLED:]
        assert np.mean((error / sigma) ** 2) < 3.3
        assert np.degrees(sigma).mean() < (0.1 if not stem else 2.0)


def test_without_calibration_the_error_is_many_times_larger_and_sigma_says_so() -> None:
    """The negative control: the drawing and what `identify` alone says of the cables."""
    of = case(SEEDS[0], calibrated=False)
    seen = observe_log(of.neck, of.model, part(of, 1500)).series
    angle, _ = errors(of, seen)
    sigma = seen.matrix("sigma_alpha")[SETTLED:]
    assert np.degrees(np.sqrt(np.mean(angle**2, axis=0))).max() > 0.3
    assert np.sqrt(np.mean((angle / sigma) ** 2)) < 1.5


def test_the_observer_is_causal_and_the_same_row_by_row() -> None:
    of = case(SEEDS[0])
    whole = observe_log(of.neck, of.model, part(of, 60)).series.matrix("alpha")
    observer = Observer(of.neck, of.model)
    theta, f = of.log.matrix("theta"), of.log.matrix("f")
    rows = [observer.step(theta[row], f[row])[0] for row in range(60)]
    np.testing.assert_allclose(np.array(rows), whole, atol=1e-9)


def test_smoothing_is_no_worse_and_knows_it() -> None:
    of = case(SEEDS[0])
    filtered, smooth = (observe_log(of.neck, of.model, part(of, 1100), smooth=s).series for s in (False, True))
    rms = [np.sqrt(np.mean(errors(of, s)[1] ** 2)) for s in (filtered, smooth)]
    assert rms[1] < rms[0]
    assert smooth.matrix("sigma_alpha", "_d").mean() < filtered.matrix("sigma_alpha", "_d").mean()


def test_a_smoothed_row_is_known_where_the_observer_began() -> None:
    """The first row, and the first after a gap, are told by those after them as well as others are."""
    of = case(SEEDS[0])
    rows = np.r_[0:300, 1500:1800]
    seen = observe_log(of.neck, of.model, of.log.part(rows), smooth=True).series
    for stem, limit in (("", 0.4), ("_d", 10.0)):
        error = seen.matrix("alpha", stem) - (of.alpha_d if stem else of.alpha)[rows]
        sigma = seen.matrix("sigma_alpha", stem)
        for first in (0, 300):
            near = slice(first, first + 10)
            assert np.degrees(np.abs(error[near])).max() < limit
            assert np.abs(error[near] / sigma[near]).max() < 4


def with_unknown_x0(of: Case) -> Case:
    """The same arm after its motors were switched on anew: nobody knows where they stand."""
    assert of.model.pose is not None
    pose = of.model.pose
    kept = [i for i, n in enumerate(pose.numbers) if n.kind != "x0"]
    numbers = tuple(pose.numbers[i] for i in kept)
    covariance = tuple(tuple(pose.covariance[i][j] for j in kept) for i in kept)
    model = of.model.model_copy(update={"pose": pose.model_copy(update={"numbers": numbers, "covariance": covariance})})
    return Case(of.neck, model, of.log, of.alpha, of.alpha_d)


def a_frame_a_second(of: Case, log: Series) -> FrameAngles:
    rows = np.arange(0, len(log), 500)
    alpha = of.alpha[rows] + NOISE_RAD * np.random.default_rng(1).standard_normal((len(rows), 3))
    sigma = np.full_like(alpha, NOISE_RAD)
    return FrameAngles(log.time[rows], alpha, sigma, np.zeros_like(sigma))


def test_a_frame_a_second_halves_what_follows_the_pose() -> None:
    """0.3 kg on the tip that no law has: after ten frames half of its error is gone, and more of it smoothed by all of them."""
    of = unexplained("load")
    frames = a_frame_a_second(of, of.log)
    rms = []
    for given, smooth in ((None, False), (frames, False), (frames, True)):
        angle, _ = errors(of, observe_log(of.neck, of.model, of.log, frames=given, smooth=smooth).series)
        rms.append(np.sqrt(np.mean(angle[len(angle) // 2 :] ** 2)))
    assert rms[1] < rms[0] / 2
    assert rms[2] < rms[1] / 1.3


def test_frames_that_are_worse_than_the_model_do_not_harm() -> None:
    """Frames of 0.02 deg, where motors alone tell joints within 0.004."""
    of = unexplained("friction")
    alone, helped = (
        errors(of, observe_log(of.neck, of.model, of.log, frames=given).series)[0]
        for given in (None, a_frame_a_second(of, of.log))
    )
    assert np.sqrt(np.mean(helped**2)) < 1.2 * np.sqrt(np.mean(alone**2))


def test_a_frame_a_second_finds_pre_elongations_that_nobody_knows() -> None:
    """Without a frame errors are degrees, and sigma says so; with one a second they are less than half of that."""
    of = with_unknown_x0(case(SEEDS[0]))
    log = part(of, 2000)
    frames = a_frame_a_second(of, log)
    blind, helped = (observe_log(of.neck, of.model, log, frames=given).series for given in (None, frames))
    assert np.sqrt(np.mean(errors(of, helped)[0] ** 2)) < np.sqrt(np.mean(errors(of, blind)[0] ** 2)) / 2
    for seen in (blind, helped):
        angle, _ = errors(of, seen)
        assert np.sqrt(np.mean((angle / seen.matrix("sigma_alpha")[SETTLED:]) ** 2)) < 2


def test_a_gap_of_the_log_begins_anew() -> None:
    of = case(SEEDS[0])
    log = of.log.part(np.r_[0:800, 2000:3000])
    seen = observe_log(of.neck, of.model, log)
    assert seen.restarts == 1
    after = seen.series.matrix("alpha")[-400:] - of.alpha[2600:3000]
    assert np.degrees(np.abs(after)).max() < 0.3


def test_sigma_holds_what_a_short_gap_leaves() -> None:
    """From 0.1 to 0.9 s: commands changed meanwhile, and nobody saw them. The row after is no further off than others are."""
    of = case(SEEDS[0])
    for missing in (45, 150, 450):
        rows = np.r_[0:700, 700 + missing : 1000 + missing]
        seen = observe_log(of.neck, of.model, of.log.part(rows)).series
        for stem, true in (("", of.alpha), ("_d", of.alpha_d)):
            ratio = np.abs(seen.matrix("alpha", stem) - true[rows]) / seen.matrix("sigma_alpha", stem)
            assert ratio[700:710].max() < 3
            assert ratio[710:].max() < 10  # as without a gap, for rates where motors turn round


def test_what_the_observer_cannot_do_is_refused() -> None:
    of = case(SEEDS[0], calibrated=False)
    unsure = tuple(p.model_copy(update={"identified": p.name != "k"}) for p in of.model.parameters)
    with pytest.raises(Refused, match=r"k\(1\).* was not identified"):
        Observer(of.neck, of.model.model_copy(update={"parameters": unsure}))
    without = Series(of.log.time, {n: c for n, c in of.log.columns.items() if n.startswith("theta")})
    with pytest.raises(Refused, match="no forces"):
        observe_log(of.neck, of.model, without)
    with pytest.raises(Refused, match="not finite"):
        Observer(of.neck, of.model).step(np.full(4, np.nan), np.zeros(4))


@pytest.mark.parametrize(
    ("row", "says"),
    [
        (lambda theta, f: (theta[:3], f), r"theta has the shape \(3,\), expected \(4,\)"),
        (lambda theta, f: (theta, None), "f holds no numbers|f has the shape"),
        (lambda theta, f: ("a", f), "theta holds no numbers"),
        (lambda theta, f: (theta, f, 0.004, [0.1, 0.2], 0.01), r"angles has the shape \(2,\), expected \(3,\)"),
        (lambda theta, f: (theta, f, 0.004, [0.1, 0.2, 0.3], [0.1, 0.1]), r"sigma has the shape \(2,\)"),
        (lambda theta, f: (theta, f, 0.002), "time stands still: 0.002 s after 0.002 s; give each row once"),
        (lambda theta, f: (theta, f, 0.001), "time goes back: 0.001 s after 0.002 s"),
        (lambda theta, f: (theta, f, float("nan")), "time is no number"),
    ],
)
def test_a_row_that_is_none_is_refused(row: Callable[[np.ndarray, np.ndarray], tuple[Any, ...]], says: str) -> None:
    of = case(SEEDS[0])
    observer = Observer(of.neck, of.model)
    theta, f = of.log.matrix("theta"), of.log.matrix("f")
    for k in range(2):
        observer.step(theta[k], f[k], 0.002 * k)
    with pytest.raises(Refused, match=says):
        observer.step(*row(theta[2], f[2]))
    observer.step(theta[2], f[2], 0.004)  # what is refused leaves nothing behind


@pytest.mark.parametrize(
    ("start", "says"),
    [
        (5, r"start has the shape \(\), expected \(3,\)"),
        ([0.1, 0.2], r"\(2,\), expected"),
        ([5, -3, 2], "give them in rad"),
    ],
)
def test_a_start_that_is_none_is_refused(start: Any, says: str) -> None:
    of = case(SEEDS[0])
    with pytest.raises(Refused, match=says):
        observe_log(of.neck, of.model, of.log.part(slice(0, 10)), start=start)


@pytest.mark.parametrize("step_s", [0.0, -0.002, float("nan")])
def test_rows_that_are_no_time_apart_are_refused(step_s: float) -> None:
    of = case(SEEDS[0])
    with pytest.raises(Refused, match="s apart are none; give step_s"):
        Observer(of.neck, of.model, step_s)
