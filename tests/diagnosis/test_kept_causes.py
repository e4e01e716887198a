"""Which causes stay though their numbers are told badly, where, and when others are sought: decided on stages made up."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from diagnosis import cause_search, single_place
from diagnosis.cause import Cause
from diagnosis.effects import EFFECTS
from diagnosis.noise_excess import NoiseExcess
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))


def left(ratio: float) -> Any:
    return SimpleNamespace(excess=NoiseExcess(np.array([ratio]), np.ones(1)), possible=True)


@pytest.mark.parametrize(
    ("with_it", "without", "goes"),
    [
        (2.0, 7.4, False),  # one cable that hardens, beside numbers of its own stiffness: no amount is told
        (2.0, 2.5, True),  # takes a part of what is left, as a law of another form does
        (1.05, 1.3, True),  # nothing is left plainly without it
    ],
)
def test_a_cause_that_is_not_told_goes_unless_the_others_leave_far_more(
    with_it: float, without: float, goes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    rest = left(without)
    monkeypatch.setattr(cause_search, "fitted_without", lambda fitter, stage, left_out: rest)
    stage = left(with_it)
    stage.causes, stage.untold = (None, None), (1,)
    assert cause_search._without_untold(cast("Any", None), stage) is (rest if goes else None)


@pytest.mark.parametrize(
    ("amounts", "sigma", "place"),
    [
        ([5e3, -1e3, 4e5, 4e2], [3e4, 1e4, 1e4, 1e4], 3),  # told, the others not
        ([5e3, -1e3, 4e5, 4e2], [3e4, 1e4, 9e5, 1e4], 3),  # none is told: the one that holds nearly all
        ([2e5, -1e3, 4e5, 4e2], [9e5, 9e5, 9e5, 9e5], None),  # none is told, and two hold it
        ([2e5, -1e3, 4e5, 4e2], [1e4, 9e5, 1e4, 1e4], None),
    ],
)
def test_a_cause_sits_alone_where_the_others_have_next_to_nothing(
    amounts: list[float], sigma: list[float], place: int | None
) -> None:
    effect = EFFECTS["cable_hardening"]
    everywhere = Cause(effect, effect.placements(ARM)[0], np.array(amounts), dict(effect.start_shapes[0]))
    alone = single_place._alone(everywhere, np.append(sigma, 1.0), ARM)
    assert (alone and alone.where.label) == (place and f"cable {place}")


@pytest.mark.parametrize(
    ("takes", "of_all", "cleared", "stays"),
    [
        (1.2, 1e-4, False, False),  # a play that mends the form of friction of pulleys
        (0.2, 0.003, False, False),  # bristles that mend a lag
        (5.0, 1e-4, False, True),
        (1.7, 0.007, False, True),  # cables that harden, where a payload is 99 % of all
        (1.2, 0.03, False, True),  # a part of all that is no small one
        (1.2, 1e-4, True, True),  # an equation that had four times noise has none any more
    ],
)
def test_what_takes_little_of_all_and_of_what_is_left_is_no_cause(
    takes: float, of_all: float, cleared: bool, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """takes: times what is left."""
    surplus = 1000.0
    gain = takes * surplus
    causes = tuple(SimpleNamespace(gain=each) for each in (gain / 1e-5, gain))
    last = left(4.0)
    last.surplus, last.excess = surplus, NoiseExcess(np.array([4.0, 1.0]), np.ones(2))
    rest = left(4.0)
    rest.surplus, rest.excess = surplus + gain, NoiseExcess(np.array([4.5, 4.0 if cleared else 1.0]), np.ones(2))
    monkeypatch.setattr(cause_search, "fitted_without", lambda fitter, stage, left_out: rest)
    first = cast("Any", SimpleNamespace(surplus=gain / of_all))
    kept, stage = cause_search._without_stand_ins(cast("Any", None), first, cast("Any", causes), last)
    assert (len(kept), stage) == ((2, last) if stays else (1, rest))


@pytest.mark.parametrize(
    ("surpluses", "ratio", "choices"),
    [
        ([1000.0], 4.0, 0),  # none explains as much as what was chosen
        ([600.0], 4.0, 0),  # a little more than that
        ([400.0, 300.0], 4.0, 1),  # far more: what was chosen beside it was chosen beside the wrong one
        ([400.0, 300.0], 1.2, 0),  # and nothing else is there
        ([400.0, 100.0, 30.0, 9.0], 4.0, 3),  # not without end
    ],
)
def test_others_are_sought_beside_what_leaves_far_less_in_the_place_of_another(
    surpluses: list[float], ratio: float, choices: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stage(surplus: float) -> Any:
        made = left(ratio)
        made.surplus = surplus
        return made

    exchanged, sought = iter(map(stage, surpluses)), list[Any]()
    fitter = cast("Any", SimpleNamespace(whiten=None, with_own_weights=lambda stage: (fitter, stage)))

    def chosen(fitter: Any, last: Any, *_: object) -> tuple[Any, Any]:
        sought.append(last)
        return fitter, last

    monkeypatch.setattr(cause_search, "with_single_places", lambda fitter, last: last)
    monkeypatch.setattr(cause_search, "with_look_alikes", lambda fitter, last: ((), next(exchanged)))
    monkeypatch.setattr(cause_search, "with_effects", lambda last, whiten: None)
    monkeypatch.setattr(cause_search, "with_all_causes", chosen)
    *_, last = cause_search._with_exchanges(fitter, stage(1000.0), cast("Any", None), seed=0)
    assert [each.surplus for each in sought] == surpluses[:choices]
    assert last.surplus == surpluses[choices]
