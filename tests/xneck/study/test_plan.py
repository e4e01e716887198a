"""What a study runs follows from its options alone."""

from typing import Any

import pytest

from samples.generator.hidden.experiment import CATALOGUE, KINDS, MANNERS
from xneck.cli.study import command
from xneck.study.plan import Case, StudyOptions, effect_sets, planned_cases
from xneck_foundation.errors import Refused


def planned(
    seeds: int = 3, pairs: int = 0, effects: Any = ((), ("base_tilt",)), manners: Any = ("rich",)
) -> tuple[Case, ...]:
    options = StudyOptions(
        effects=effects,
        seeds=range(50, 50 + seeds),
        pairs=pairs,
        manners=manners,
        size=(0.2, 1.0),
        noise_deg=0.1,
        seconds=(60.0, 60.0),
    )
    return planned_cases(options, [*CATALOGUE])


def test_a_longer_study_holds_a_shorter_one() -> None:
    assert planned() == planned()
    longer = planned(seeds=6, pairs=8, effects=((), ("cogging",), ("base_tilt",)), manners=("rich", "slow"))
    assert set(planned(pairs=4)) < set(longer)
    assert len({case.name for case in longer}) == len(longer)


def test_sizes_are_in_their_range_and_differ_but_for_nothing() -> None:
    cases = planned(seeds=40)
    assert {case.size for case in cases if not case.kinds} == {1.0}
    sizes = [case.size for case in cases if case.kinds]
    assert 0.2 <= min(sizes) < 0.3
    assert 0.9 < max(sizes) <= 1.0


def test_pairs_are_two_of_the_catalogue_that_differ_from_seed_to_seed() -> None:
    pairs = [case.kinds for case in planned(seeds=0, pairs=30)]
    assert len(pairs) == 30
    assert len(set(pairs)) > 20
    assert all(len(set(pair)) == 2 and set(pair) <= set(CATALOGUE) for pair in pairs)


def test_words_for_effects() -> None:
    kinds, catalogue = [*KINDS], [*CATALOGUE]
    every = effect_sets(["all"], kinds, catalogue)
    assert every == ((), *((kind,) for kind in kinds))
    assert effect_sets(["none", "base_tilt,cable_slack"], kinds, catalogue) == ((), ("base_tilt",), ("cable_slack",))
    both = effect_sets(["cable_slack+cogging"], kinds, catalogue)
    assert both == effect_sets(["cogging+cable_slack", "cable_slack+cogging"], kinds, catalogue)
    assert len(effect_sets(["catalogue", "outside"], kinds, catalogue)) == len(kinds)
    with pytest.raises(Refused, match="unknown effect 'gremlins'; valid: all, catalogue"):
        effect_sets(["gremlins"], kinds, catalogue)


def test_the_command_offers_the_generators_manners() -> None:
    (manner,) = (p for p in command.params if p.name == "manners")
    assert tuple(manner.type.choices) == MANNERS  # pyright: ignore[reportAttributeAccessIssue]
