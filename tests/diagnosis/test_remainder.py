"""What nothing named explains is said of every equation, and of the verdict where it is plainly more than noise."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.diagnose import TOO_MANY_TIED, _verdict
from diagnosis.noise_excess import NoiseExcess
from diagnosis.remainder import MAX_REMAINDER, Remainder, plainly_left, remainders

FLOOR = np.array([0.5, 0.5, 0.01])
PLAIN = 2 * MAX_REMAINDER
NEAR = 1 + (MAX_REMAINDER - 1) / 2


def left_with(*ratios: float) -> tuple[Remainder, ...]:
    """Of two motors and a joint, which stand so many times above noise; ten times as much before."""
    after = NoiseExcess(FLOOR * np.array(ratios), FLOOR)
    return remainders(NoiseExcess(10 * after.rms, FLOOR), after, motors=2, held_out=True)


def test_every_equation_has_its_unit_its_rms_and_its_noise() -> None:
    said = [r.as_json() for r in left_with(1.0, 2.0, 3.0)]
    assert [r["unit"] for r in said] == ["N", "N", "N m"]
    assert len({r["equation"] for r in said}) == 3
    np.testing.assert_allclose([r["before"] for r in said], [5.0, 10.0, 0.3])
    np.testing.assert_allclose([r["after"] for r in said], [0.5, 1.0, 0.03])
    np.testing.assert_allclose([r["noise_floor"] for r in said], FLOOR)
    assert all(r["held_out"] is True for r in said)


def test_what_is_plainly_left_is_named_the_largest_first() -> None:
    left = left_with(PLAIN, NEAR, 2 * PLAIN)
    assert plainly_left(left) == (left[2], left[0])
    assert plainly_left(left_with(NEAR, 1.0, 0.9)) == ()


def verdict(
    *ratios: float,
    tied: tuple[int, ...] = (1,),
    above_noise: bool = True,
    holds: bool = True,
    explained: float | None = None,
) -> tuple[str, str]:
    """tied: of each cause that is named, how many explain as much; explained: by a law that nobody listed."""
    named = [SimpleNamespace(tied=[None] * count) for count in tied]
    function = SimpleNamespace(equation="motors", follows="force")
    unlisted = None if explained is None else SimpleNamespace(function=function, explains=explained)
    first = SimpleNamespace(excess=SimpleNamespace(above_noise=above_noise))
    search: Any = SimpleNamespace(named=named, first=first, unlisted=unlisted)
    found: Any = SimpleNamespace(search=search, laws=(), held=SimpleNamespace(holds=holds), stretches=())
    visible: Any = SimpleNamespace(invisible=(), effects=("a", "b"))
    return _verdict(found, visible, left_with(*ratios))


@pytest.mark.parametrize(
    ("tied", "kind"),
    [((1,), "cause"), ((1, 1, 1, 1, 1), "cause"), ((1, 2), "ambiguous"), ((TOO_MANY_TIED,), "insufficient")],
)
def test_a_verdict_says_that_something_unknown_remains(tied: tuple[int, ...], kind: str) -> None:
    said, why = verdict(1.0, PLAIN, 1.0, tied=tied)
    assert said == kind
    assert f"something unknown remains: {left_with(1.0, PLAIN, 1.0)[1].equation}" in why
    assert f"{PLAIN:.1f} times noise" in why
    said, why = verdict(1.0, NEAR, 1.0, tied=tied)
    assert said == kind
    assert "remains" not in why


def test_what_does_not_hold_on_other_recordings_is_insufficient() -> None:
    said, why = verdict(1.0, PLAIN, 1.0, holds=False)
    assert said == "insufficient"
    assert f"{PLAIN:.1f} times noise" in why


@pytest.mark.parametrize(("explained", "told"), [(None, False), (0.2, False), (0.9, True)])
def test_what_the_rest_follows_is_said_where_it_is_a_good_part(explained: float | None, told: bool) -> None:
    said, why = verdict(PLAIN, PLAIN, PLAIN, tied=(), explained=explained)
    assert said == "unknown"
    assert ("a law of the motors that follows the force" in why) == told
    assert ("90%" in why) == told
    assert verdict(1.0, 1.0, 1.0, tied=(), above_noise=False) == ("consistent", "nothing stands above noise")
    assert ("follows the force" in verdict(PLAIN, 1.0, 1.0, explained=explained)[1]) == told
