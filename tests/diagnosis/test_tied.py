"""Which causes data cannot tell apart, by what each leaves."""

from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.look_alikes import indistinguishable
from diagnosis.worth_naming import MIN_LOSS_SHARE

NOISE_LOSS = 9000.0


def one(name: str, loss: float, numbers: int = 1, above_noise: bool = False) -> Any:
    """A cause by its name, and a fit with it."""
    stage = SimpleNamespace(
        fit=SimpleNamespace(loss=loss), surplus=loss - NOISE_LOSS, excess=SimpleNamespace(above_noise=above_noise)
    )
    return SimpleNamespace(effect=SimpleNamespace(name=name), number_count=numbers), stage


def names(*tried: Any, gain: float = 1e6) -> list[str]:
    return [str(c.effect.name) for c, _ in indistinguishable(tried, gain)]


def test_what_leaves_as_little_is_tied_and_the_best_is_first() -> None:
    assert names(one("near", 10_100.0), one("best", 10_000.0), one("far", 10_000 * (1 + 1.1 * MIN_LOSS_SHARE))) == [
        "best",
        "near",
    ]


@pytest.mark.parametrize("above_noise", [False, True])
def test_what_leaves_something_above_noise_is_not_tied_with_what_leaves_none(above_noise: bool) -> None:
    """All its loss may stand in one channel, where it is little of the whole."""
    told = names(one("best", 10_000.0, above_noise=above_noise), one("loud", 10_300.0, above_noise=True))
    assert told == (["best", "loud"] if above_noise else ["best"])


def test_more_numbers_must_leave_less() -> None:
    assert names(one("plain", 10_100.0), one("rich", 10_000.0, numbers=4)) == ["plain"]
    assert names(one("plain", 10_700.0), one("rich", 9_500.0, numbers=4)) == ["rich"]


def test_little_gain_is_told_by_less() -> None:
    """A number a little beyond its tolerance takes 20 of a loss of 10,000: what leaves 15 more explains nothing."""
    assert names(one("best", 10_000.0), one("none", 10_015.0), gain=20.0) == ["best"]
    assert names(one("best", 10_000.0), one("chance", 10_005.0), gain=20.0) == ["best", "chance"]
