"""Friction that bends before it slides is identified with the rest where nothing fits without it."""

import numpy as np
import pytest

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from identification.estimate_table import BENDS, as_text
from identification.estimates import BENDING_FRICTION, DEFAULT_LAWS, estimate
from samples.generator.laws import bending, dry_and_viscous, linear
from samples.generator.prescribed import World, prescribe
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from tests.identification.test_estimates import CA, FILE, FS, NECK, K, recording
from xneck_foundation.strict_yaml import parse_yaml

SHARPNESS = 0.5


def bent_by(width: float, seed: int) -> DataSet:
    """All dry friction in elements that give way straight up to a width, rad of the motor, and then slip: none of our laws."""
    dry, bends = dry_and_viscous(FS, np.zeros(4)), bending(FS, np.full((3, 4), width), SHARPNESS)
    world = World(parse_yaml(FILE.read_text(), str(FILE)), linear(K, CA), lambda at: dry(at) + bends(at))
    made = prescribe(world, 30.0, seed)
    sigma = np.radians(0.02)
    alpha = made.frame_alpha + np.random.default_rng([seed, 5]).normal(0, sigma, made.frame_alpha.shape)
    log = Series(made.log_time, numbered_columns("theta", made.counted) | numbered_columns("f", made.f))
    return synchronise(NECK, "", Angles(made.frame_times, alpha, np.full(alpha.shape, sigma)), log, {})


@pytest.mark.parametrize("width", [0.05, 0.2])
def test_what_bends_is_told_with_friction_and_stiffness(width: float) -> None:
    """Elements that slip at once are no bristles that bend less and less: friction is then off by some per cent, not by tens."""
    found = estimate([bent_by(width, 2100)])
    assert found.laws == (*DEFAULT_LAWS, BENDING_FRICTION)
    np.testing.assert_allclose(found.values("fs"), FS, rtol=0.05)
    np.testing.assert_allclose(found.values("k"), K, rtol=0.02)
    np.testing.assert_allclose(found.values("wp"), width, rtol=0.2)
    assert BENDS in as_text(found)


def test_friction_that_slides_at_once_needs_no_such_law() -> None:
    """Control."""
    found = estimate([recording(2000, 0.02)])
    assert found.laws == DEFAULT_LAWS
    assert BENDS not in as_text(found)
