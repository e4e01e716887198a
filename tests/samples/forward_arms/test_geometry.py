"""Folded mechanisms and taut cables: lengths that are kept, strings around pulleys, levers."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from samples.forward_arms.cables import NONE, WORDS, lengths, levers
from samples.forward_arms.joints import folded, placed
from samples.forward_arms.plant import side_by_side
from tests.samples.forward_arms.plants import odd_plant


def test_bars_and_diagonals_keep_their_lengths() -> None:
    plant = side_by_side([odd_plant()])
    alpha = np.random.default_rng(1).uniform(-1.2, 1.2, (3, 50))
    fold = folded(plant, alpha)
    place = placed(fold)
    half = plant.b / 2
    low_left, low_right = (place.middle[:-1] + s * half * place.along[:-1] for s in (-1, 1))
    high_left, high_right = (place.middle[1:] + s * half * place.along[1:] for s in (-1, 1))
    for a, b in ((low_left, high_right), (low_right, high_left)):
        np.testing.assert_allclose(np.abs(a - b), np.broadcast_to(plant.L, alpha.shape), rtol=1e-13)
    np.testing.assert_allclose(np.abs(high_left - low_left), fold.left, rtol=1e-13)
    np.testing.assert_allclose(np.abs(high_right - low_right), fold.right, rtol=1e-13)
    np.testing.assert_allclose(np.angle(place.along[1:] / place.along[:-1]), alpha, atol=1e-14)


def test_the_straight_pose_stands_upright_and_poses_mirror() -> None:
    plant = side_by_side([odd_plant()])
    straight = placed(folded(plant, np.zeros((3, 1))))
    height = np.cumsum(np.sqrt(plant.L**2 - plant.b**2), axis=0)
    np.testing.assert_allclose(straight.middle[1:], 1j * height, atol=1e-16)
    alpha = np.array([[0.4], [-0.7], [0.2]])
    one, other = (placed(folded(plant, s * alpha)).middle for s in (1, -1))
    np.testing.assert_allclose(other, -one.conj(), atol=1e-16)


@dataclass(frozen=True)
class Disc:
    """A pulley that a string goes around, counter-clockwise (+1) or clockwise (-1)."""

    centre: complex
    radius: float
    sense: int

    def at(self, angle: float) -> complex:
        return self.centre + self.radius * np.exp(1j * angle)

    def touched(self, seen_from: complex, leaving: bool) -> float:
        """Angle of the point at which a taut string to or from a point touches: the utmost that is seen from there."""
        side = self.sense if leaving else -self.sense
        towards = self.centre - seen_from

        best, width = 0.0, np.pi
        for _ in range(10):
            tried = best + np.linspace(-width, width, 121)
            points = self.centre + self.radius * np.exp(1j * tried)
            best = float(tried[np.argmax(side * np.angle((points - seen_from) / towards))])
            width /= 30
        return best


def string_length(discs: list[Disc], first: float, last: float | None) -> float:
    """From the point at angle `first` of the first disc to that at `last` of the last one, or to its centre."""
    total, arrived = 0.0, first
    for i, (here, there) in enumerate(pairwise(discs)):
        ends = last is None and i == len(discs) - 2
        target, leave, arrive = there.centre, 0.0, 0.0
        for _ in range(60):  # the two points of contact find each other
            leave = here.touched(target, leaving=True)
            arrive = 0.0 if ends else there.touched(here.at(leave), leaving=False)
            before, target = target, there.centre if ends else there.at(arrive)
            if abs(before - target) < 1e-13:
                break
        total += here.radius * ((here.sense * (leave - arrived)) % (2 * np.pi)) + abs(target - here.at(leave))
        arrived = arrive
    if last is not None:
        total += discs[-1].radius * ((discs[-1].sense * (last - arrived)) % (2 * np.pi))
    return total


@pytest.mark.parametrize("word", WORDS)
def test_cables_are_taut_strings(word: str) -> None:
    plant = odd_plant(1)
    alone = replace(plant, routes=np.full((1, plant.M), WORDS.index(word)))
    batch = side_by_side([alone])
    b, r = float(plant.b[0]), float(plant.r[0])
    for alpha in (-0.8, 0.0, 0.5):
        bend = np.array([[alpha]])
        fold = folded(batch, bend)
        place = placed(fold)
        corner = {(k, s): complex(place.middle[k, 0] + s * b / 2 * place.along[k, 0]) for k in (0, 1) for s in (-1, 1)}
        side = 1 if word in ("right", "right_through", "strut") else -1
        discs = [Disc(corner[0, side], r, side)]
        if "strut" in word:
            discs.append(Disc(corner[1, -side], r, -side))
        discs.append(Disc(corner[1, side], r, side))
        lowest = None if word in ("right", "left") else alpha - np.pi / 2
        expected = string_length(discs, -np.pi / 2, lowest)
        assert lengths(batch, fold, bend)[0, 0] == pytest.approx(expected, abs=1e-8)


def test_levers_are_how_lengths_change() -> None:
    plant = side_by_side([odd_plant()])
    alpha, e = np.random.default_rng(2).uniform(-0.8, 0.8, (3, 20)), 1e-6
    Z = levers(plant, folded(plant, alpha))
    for i in range(3):
        step = np.zeros_like(alpha)
        step[i] = e
        one, other = (lengths(plant, folded(plant, a), a) for a in (alpha + step, alpha - step))
        np.testing.assert_allclose(Z[i], -(one - other) / (2 * e), atol=1e-9)


def test_cables_that_do_not_reach_have_no_lever() -> None:
    plant = odd_plant()
    Z = levers(side_by_side([plant]), folded(side_by_side([plant]), np.zeros((3, 1))))[..., 0]
    assert np.all((Z == 0) >= (plant.routes == NONE))
    assert np.all(Z[plant.routes == NONE] == 0)
