"""Frames of another clock, of another motion or with turned signs are refused; right ones never, whatever the model lacks."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles
from identification.dataset.series import Series, numbered_columns
from observation.observed_log import observe_log
from tests.observation.arms import CHANGES, NOISE_RAD, SEEDS, Case, calibration_data, case, changed, unexplained
from xneck_foundation.errors import Refused

ROWS = 3000


def frames_of(of: Case, every: int, noise_rad: float = NOISE_RAD) -> FrameAngles:
    """Of an arm, one frame in so many rows."""
    rows = np.arange(100, ROWS, every)
    sigma = np.full((len(rows), of.neck.N), noise_rad)
    noise = sigma * np.random.default_rng(every).standard_normal(sigma.shape)
    return FrameAngles(of.log.time[rows], of.alpha[rows] + noise, sigma, np.zeros_like(sigma))


def observed_misfit(of: Case, frames: FrameAngles | DataSet) -> float:
    found = observe_log(of.neck, of.model, of.log.part(slice(0, ROWS)), frames).consistency
    assert found is not None
    return found.misfit


@pytest.mark.parametrize("every", [17, 500], ids=["30 a second", "one a second"])
def test_of_right_frames_nothing_is_said(every: int) -> None:
    of = case(SEEDS[0])
    assert 0.2 < observed_misfit(of, frames_of(of, every)) < 1.5


@pytest.mark.parametrize("name", sorted(CHANGES))
def test_a_model_that_lacks_something_is_no_fault_of_the_frames(name: str) -> None:
    """0.3 kg on the tip put joints 0.5 deg beside the model: twenty times the noise of frames."""
    for of in (changed(name), unexplained(name)):
        assert np.isfinite(observed_misfit(of, frames_of(of, 250)))  # told, and not refused


CLOCK, OTHER = (
    r"about (18|19|20|21) ms late on this log's clock",
    "do not fit this log: alpha1, .* as much as they move",
)


def by(angles: Callable[[np.ndarray], np.ndarray]) -> Callable[[FrameAngles], FrameAngles]:
    return lambda frames: replace(frames, alpha=angles(frames.alpha))


@pytest.mark.parametrize("every", [17, 250])
@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (lambda frames: replace(frames, time=frames.time + 0.02), CLOCK),
        (by(lambda alpha: -alpha), OTHER),
        (by(lambda alpha: 2.9 * alpha), OTHER),
        (by(lambda alpha: alpha[:, ::-1]), "do not fit this log"),
        (by(lambda alpha: np.roll(alpha, len(alpha) // 2, axis=0)), "do not fit this log"),
    ],
    ids=["another clock", "turned signs", "another unit", "exchanged joints", "another time"],
)
def test_wrong_frames_are_refused(every: int, wrong: Callable[[FrameAngles], FrameAngles], says: str) -> None:
    of = case(SEEDS[0])
    with pytest.raises(Refused, match=says):
        observed_misfit(of, wrong(frames_of(of, every)))


def test_dense_and_sure_frames_do_not_hide_their_own_clock() -> None:
    """An observer that was told of 30 in a second follows them: then they stand beside it by little."""
    of = case(SEEDS[0])
    late = frames_of(of, 17, NOISE_RAD / 20)
    with pytest.raises(Refused, match=CLOCK):
        observed_misfit(of, replace(late, time=late.time + 0.02))


def test_a_scale_that_is_off_is_asked_about() -> None:
    of = case(SEEDS[0])
    right, wrong = (
        observe_log(
            of.neck, of.model, of.log.part(slice(0, ROWS)), replace(frames, alpha=scale * frames.alpha)
        ).as_json()
        for frames in (frames_of(of, 100),)
        for scale in (1.0, 1.2)
    )
    assert right["frames_doubt"] is None
    assert "is their scale right" in wrong["frames_doubt"]


def test_a_data_set_of_another_recording_is_refused() -> None:
    of = case(SEEDS[0])
    other, own = calibration_data(SEEDS[0])
    with pytest.raises(Refused, match=r"frames: was made with another log: its motors are .* rad beside this log's"):
        observed_misfit(of, other)
    observed_misfit(of, own)
    # rows that are missing in the log, or come later, are no other log
    part = of.log.part(np.random.default_rng(3).uniform(size=len(of.log)) < 0.7)
    theta = part.matrix("theta") + 1e-4
    observed_misfit(replace(of, log=Series(part.time, {**part.columns, **numbered_columns("theta", theta)})), own)
