"""Laws of several places: one that all have is told of all, one that a single place has is told there."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import pytest
from numpy.typing import NDArray

from discovery import search
from discovery.fine_basis import FineBasis, Function
from discovery.form import Constants, Form
from discovery.found_law import FoundLaw
from discovery.problem import Candidate, Problem
from discovery.search import find_laws

Array = NDArray[np.float64]
ROWS = 1200


class Places(Problem):
    """Each place has rows of its own, with white noise of one and a variable of its own."""

    def __init__(
        self, amounts: list[float], blocks: int = 30, counts: Sequence[float] = (5.0,), step: float = 0.3
    ) -> None:
        rng = np.random.default_rng(8)
        self._x = np.cumsum(rng.normal(0, step, (ROWS, len(amounts))), axis=0)
        self._y = np.sin(np.array(counts) * self._x) * amounts + rng.normal(size=self._x.shape)
        self._block = np.arange(ROWS) * blocks // ROWS

    @cached_property
    def target(self) -> Array:
        return self._y.T.ravel()

    @cached_property
    def base(self) -> Array:
        return np.ones((self._y.size, 1))

    @cached_property
    def precision(self) -> Array:
        return np.zeros(1)

    @cached_property
    def blocks(self) -> NDArray[np.intp]:
        return np.tile(self._block, self._x.shape[1]).astype(np.intp)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        count, basis = self._x.shape[1], FineBasis.of([self._x.ravel()], True)
        every = Candidate(
            where="all",
            follows=("motor_angle",),
            unit="rad",
            kind="turn",
            basis=basis,
            target_unit="N",
            places=count,
            detail="against the motors",
        )
        single = [
            Candidate(
                where=f"motor {i + 1}",
                follows=("motor_angle",),
                unit="rad",
                kind="turn",
                basis=basis,
                target_unit="N",
                detail="against the motors",
            )
            for i in range(count)
        ]
        return (every, *single)

    def columns(self, candidate: Candidate, function: Function) -> Array:
        count = self._x.shape[1]
        parts = [function(x) for x in self._x.T]
        out = np.zeros((count, ROWS, parts[0].shape[1], count))
        for i, part in enumerate(parts):
            out[i, :, :, i] = part
        flat = out.reshape(count * ROWS, -1, count)
        return flat.reshape(len(flat), -1) if candidate.where == "all" else flat[..., int(candidate.where[-2:]) - 1]


def test_what_all_places_have_is_one_law() -> None:
    (law,) = find_laws(Places([1.0, 0.8, 1.2, 0.9]))
    assert (law.candidate.where, law.constants) == ("all", {"count": 5.0})
    assert law.amounts[4:] == pytest.approx([1.0, 0.8, 1.2, 0.9], abs=0.2)
    assert law.words == "against all motors: harmonic of motor_angle"
    assert [p.index for p in law.parameters[:4]] == [1, 2, 3, 4]


def test_what_each_place_has_in_its_own_way_is_a_law_of_each() -> None:
    """On part of a turn, where a wrong count does much of what the right one does."""
    laws = find_laws(Places([1.5, 2.1, 1.8, 1.2], counts=[5.0, 8.0, 3.0, 6.0], step=0.08))
    told = {law.candidate.where: law.constants["count"] for law in laws}
    assert told == {"motor 1": 5.0, "motor 2": 8.0, "motor 3": 3.0, "motor 4": 6.0}
    assert len(laws) == 4


def test_what_one_place_has_is_told_there() -> None:
    (law,) = find_laws(Places([0.0, 0.0, 1.5, 0.0]))
    assert law.candidate.where == "motor 3"
    assert law.words == "against motor 3: harmonic of motor_angle"
    assert [p.index for p in law.parameters[:2]] == [None, None]


def test_with_more_places_than_blocks_single_places_are_tried() -> None:
    (law,) = find_laws(Places([0.0] * 11 + [2.0], blocks=12))
    assert law.candidate.where == "motor 12"


def test_with_few_blocks_nothing_is_told() -> None:
    assert find_laws(Places([3.0, 3.0], blocks=9)) == ()


def test_nothing_is_found_in_noise() -> None:
    assert find_laws(Places([0.0, 0.0, 0.0])) == ()


class Spring(Problem):
    """A force measured without noise, against a spring's: its stiffness is free, its length measured with noise of one newton."""

    stiffness, hinge_at = 10.0, 0.5

    def __init__(self, tells_noise: bool) -> None:
        rng = np.random.default_rng(11)
        length = np.cumsum(rng.normal(0, 0.2, ROWS))
        self._angle = np.sin(np.arange(ROWS) / 30)
        self._force = self.stiffness * length + 40 * np.maximum(self._angle - self.hinge_at, 0.0)
        self._measured = length + rng.normal(0, 1 / self.stiffness, ROWS)
        self._tells_noise = tells_noise

    @cached_property
    def target(self) -> Array:
        return self._force - self.stiffness * self._measured

    @cached_property
    def base(self) -> Array:
        return self._measured[:, None]

    @cached_property
    def precision(self) -> Array:
        return np.zeros(1)

    @cached_property
    def blocks(self) -> NDArray[np.intp]:
        return np.arange(ROWS) * 30 // ROWS

    def noise(self, numbers: Array) -> Array:
        return np.minimum((1 + numbers / self.stiffness) ** 2, 1.0) if self._tells_noise else np.ones(1)

    @cached_property
    def candidates(self) -> tuple[Candidate, ...]:
        values = {"force": self._force, "joint_angle": self._angle}
        return tuple(
            Candidate(where="", follows=(name,), unit="1", kind="line", basis=FineBasis.of([v], False))
            for name, v in values.items()
        )

    def columns(self, candidate: Candidate, function: Function) -> Array:
        return function(self._force if candidate.follows == ("force",) else self._angle)


def test_what_makes_all_forces_small_explains_nothing() -> None:
    """Least squares would have no force and no stiffness: nothing is then wrong. Noise vanishes with them, and tells."""
    (law,) = find_laws(Spring(tells_noise=True))
    assert (law.candidate.follows, law.form.name) == (("joint_angle",), "hinge")
    assert law.amounts == pytest.approx([40.0], rel=0.05)
    assert law.constants["place"] == pytest.approx(0.5, abs=0.02)
    misled = find_laws(Spring(tells_noise=False))
    assert misled[0].candidate.follows == ("force",)


class Forbidden(Places):
    """What its target follows may not be a law."""

    def allows(self, candidate: Candidate, form: Form, constants: Constants, amounts: Array) -> bool:
        return np.abs(amounts).max() < 0.5


def test_what_may_be_no_law_is_none() -> None:
    assert find_laws(Forbidden([0.0, 0.0, 1.5, 0.0])) == ()


def test_a_search_that_goes_round_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of two laws that is found makes the other one needless."""
    problem = Places([1.0, 1.0])
    first, second = (
        FoundLaw(candidate, candidate.forms[0], {}, np.zeros(2), np.zeros((2, 2)), ())
        for candidate in problem.candidates[1:]
    )
    found = 0

    def next_law(problem: Problem, laws: Sequence[FoundLaw], rng: np.random.Generator) -> FoundLaw:
        nonlocal found
        found += 1
        assert found < 20
        return second if laws and laws[0] is first else first

    monkeypatch.setattr(search, "_next_law", next_law)
    monkeypatch.setattr(search, "fitted", lambda problem, laws: laws)
    monkeypatch.setattr(search, "_where_alone", lambda problem, laws: laws)
    monkeypatch.setattr(search, "_without_needless", lambda problem, laws: laws[-1:])
    assert len(find_laws(problem)) == 1
