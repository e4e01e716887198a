"""Causes that are chosen jointly, of columns made up: rows of one number each, noise of one."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from diagnosis.elimination import Eliminated
from diagnosis.stepwise import Choices, Option, Simpler, chosen_jointly, simplest

Array = np.ndarray[Any, np.dtype[np.float64]]

ROWS = 400
LEAST_GAIN = 20.0
SIMPLER = Simpler(0.05, lambda loss: 50.0)
_BASE = 3
"""columns before those of the options"""


def unit_columns(count: int, seed: int = 0) -> Array:
    """Columns of length one that are orthogonal to each other, (rows, count)."""
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(ROWS, count)))[0]


def choices(columns: Mapping[str, Array], residual: Array, low: float = -np.inf) -> Choices:
    """An option of each effect: columns (rows, numbers) that are added to the residual (rows,)."""
    A = np.column_stack(list(columns.values()))
    system = Eliminated(_BASE, A.T @ A, -A.T @ residual, float(residual @ residual))
    options, first = [], _BASE
    for name, each in columns.items():
        where = np.arange(first, first + each.shape[1])
        options.append(Option(name, where, np.full(len(where), low), len(where)))
        first += len(where)
    return Choices(system, options)


def chosen(table: Choices, start: Sequence[str] = (), least_gain: float = LEAST_GAIN) -> list[str]:
    """Effects of the options, in the order of the table."""
    names = [option.effect for option in table.options]
    found = chosen_jointly(table, [names.index(name) for name in start], lambda i, loss: least_gain, SIMPLER)
    return [names[i] for i in sorted(found)]


def stand_in() -> Choices:
    """Two that overlap are hidden; a third resembles their sum, and takes more than either alone."""
    a, c, e, noise = unit_columns(4).T
    b = (a + c) / np.sqrt(2)
    between = (a + b) / np.linalg.norm(a + b) + 0.3 * e
    residual = -(30 * a + 30 * b) + noise
    return choices({"a": a[:, None], "b": b[:, None], "stand-in": between[:, None]}, residual)


def test_two_that_overlap_are_chosen_where_one_by_one_takes_a_stand_in() -> None:
    table = stand_in()
    gains = {option.effect: table.loss([]) - table.loss([i]) for i, option in enumerate(table.options)}
    assert max(gains, key=lambda name: gains[name]) == "stand-in"
    assert chosen(table) == ["a", "b"]


def test_a_stand_in_that_is_there_already_is_given_up() -> None:
    assert chosen(stand_in(), ["stand-in"]) == ["a", "b"]
    assert chosen(stand_in(), ["a", "b", "stand-in"]) == ["a", "b"]


def test_the_loss_of_a_choice_is_that_of_least_squares() -> None:
    rng = np.random.default_rng(1)
    columns = {name: rng.normal(size=(ROWS, count)) for name, count in (("one", 1), ("two", 2), ("three", 3))}
    residual = rng.normal(size=ROWS)
    table = choices(columns, residual)
    for use in ([], [0], [1], [0, 2], [2, 0, 1]):
        A = np.column_stack([np.zeros((ROWS, 0)), *(columns[table.options[i].effect] for i in sorted(use))])
        left = residual - A @ np.linalg.lstsq(A, residual, rcond=None)[0]
        np.testing.assert_allclose(table.loss(use), left @ left, rtol=1e-9)


def test_one_that_is_needless_is_given_up() -> None:
    a, b = unit_columns(2).T
    table = choices({"a": a[:, None], "nothing": b[:, None]}, -30 * a)
    assert chosen(table, ["a", "nothing"]) == ["a"]


def test_nothing_is_chosen_from_noise() -> None:
    """The best of forty numbers takes 20 of a loss of 400 once in three thousand times."""
    for seed in range(20):
        columns = unit_columns(40, seed)
        noise = np.random.default_rng(1000 + seed).normal(size=ROWS)
        assert chosen(choices({str(k): columns[:, k : k + 1] for k in range(40)}, noise)) == []


def test_as_many_are_chosen_as_there_are() -> None:
    columns = unit_columns(9)
    names = [str(k) for k in range(9)]
    table = choices({name: columns[:, [k]] for k, name in enumerate(names)}, -columns[:, :6] @ np.full(6, 10.0))
    assert chosen(table) == names[:6]


def test_an_effect_is_chosen_in_one_of_its_places_only() -> None:
    a, b = unit_columns(2).T
    table = choices({"a": a[:, None], "b": b[:, None]}, -30 * a - 30 * b)
    table.options = tuple(Option("same", o.columns, o.low, len(o.columns)) for o in table.options)
    assert len(chosen(table)) == 1


def test_one_place_that_takes_as_much_as_all_has_it_alone() -> None:
    columns = unit_columns(4)
    residual = -30 * columns[:, 1] - columns[:, 2]
    everywhere, alone = columns, columns[:, 1:2]
    table = choices({"everywhere": everywhere, "alone": alone}, residual)
    assert chosen(table) == ["alone"]
    assert chosen(table, ["everywhere"]) == ["alone"]
    assert simplest(table.options, {0: 100.0, 1: 90.0}, 200.0, SIMPLER) == 0
    assert simplest(table.options, {0: 100.0, 1: 96.0}, 200.0, SIMPLER) == 1


def test_one_place_that_leaves_what_is_worth_a_name_does_not_have_it_alone() -> None:
    """Nearly all of a large loss may leave more than another cause would be named for."""
    columns = unit_columns(4)
    residual = -300 * columns[:, 1] - 30 * columns[:, 2]
    table = choices({"everywhere": columns, "alone": columns[:, 1:2]}, residual)
    assert table.loss([1]) < 0.05 * table.loss([])
    assert chosen(table) == ["everywhere"]


def test_a_number_keeps_to_its_least_value() -> None:
    """Friction that would have to drive explains nothing."""
    (a,) = unit_columns(1).T
    assert chosen(choices({"friction": a[:, None]}, -30 * a, low=0.0)) == ["friction"]
    assert chosen(choices({"friction": a[:, None]}, 30 * a, low=0.0)) == []
