"""Which causes data cannot tell apart, by what each leaves."""

from types import SimpleNamespace
from typing import Any

import pytest

from diagnosis.cause_search import MATERIAL, tied

QUIET = 9000.0


def one(name: str, loss: float, numbers: int = 1, plain: bool = False) -> Any:
    """A cause by its name, and a fit with it."""
    turn = SimpleNamespace(loss=loss, quiet=QUIET, beyond=SimpleNamespace(plain=plain))
    return SimpleNamespace(effect=name, numbers=numbers), turn


def names(*tried: Any) -> list[str]:
    return [str(c.effect) for c, _ in tied(tried)]


def test_what_leaves_as_little_is_tied_and_the_best_is_first() -> None:
    assert names(one("near", 10_100.0), one("best", 10_000.0), one("far", 10_000 * (1 + 1.1 * MATERIAL))) == [
        "best",
        "near",
    ]


@pytest.mark.parametrize("plain", [False, True])
def test_what_leaves_something_above_noise_is_not_tied_with_what_leaves_none(plain: bool) -> None:
    """All its loss may stand in one channel, where it is little of the whole."""
    told = names(one("best", 10_000.0, plain=plain), one("loud", 10_300.0, plain=True))
    assert told == (["best", "loud"] if plain else ["best"])


def test_more_numbers_must_leave_less() -> None:
    assert names(one("plain", 10_100.0), one("rich", 10_000.0, numbers=4)) == ["plain"]
    assert names(one("plain", 10_700.0), one("rich", 9_500.0, numbers=4)) == ["rich"]
