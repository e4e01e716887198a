"""Angles that follow from cables err together: by what vision's noise left uncertain of the cables' law."""

from dataclasses import replace

import numpy as np
import pytest

from identification.elongation_errors import NUISANCE_VARIANCE_RATIO, ElongationErrors
from tests.identification.test_estimates import recording

ROWS, FRAMES, NOISE = 1200, 400, 2e-3
"""of rows and of frames; of a frame's angle, rad"""
OWN = np.array([4e-6, 5e-6, 3e-6, 4e-6])


def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Tensions, commands, friction for one newton, speeds, each (ROWS, 4)."""
    t = np.linspace(0, 40, ROWS)[:, None]
    phase = np.array([0.0, 1.0, 2.2, 4.0])
    speed = 12 * np.sin(1.1 * t + phase) + 5 * np.sin(2.7 * t)
    friction = 2 / np.pi * np.arctan(0.5 * speed)
    tension = 40 + 15 * np.sin(0.7 * t + phase) + 4 * np.cos(2.1 * t)
    return tension, tension + 15 * friction, friction, speed


def levers() -> np.ndarray:
    """Of three joints and four cables, (ROWS, 3, 4), m, the same in all rows."""
    return np.broadcast_to(0.03 + 0.02 * np.random.default_rng(1).normal(size=(3, 4)), (ROWS, 3, 4))


def test_errors_are_those_of_laws_fitted_to_noisy_frames() -> None:
    """Friction's size fitted to one noisy series of frames after the other; its error carried to the angles by least squares.

    Of 400 worlds a standard deviation is known to 3.5 %; four of these, and the least that a row between frames differs."""
    tension, command, friction, speed = motion()
    Z = levers()
    of_frames = np.sqrt((Z[0] ** 2).sum(axis=0)) * NOISE
    errors = ElongationErrors(of_mean=of_frames / np.sqrt(FRAMES), own=OWN, vision=np.full(3, NOISE))
    patterns = np.array(errors.of_angles(Z, tension, command, friction, speed))
    claimed = np.sqrt(np.sum(patterns**2, axis=0) / NUISANCE_VARIANCE_RATIO)
    rng, frames = np.random.default_rng(2), np.arange(0, ROWS, ROWS // FRAMES)
    W = np.diag(OWN**-2.0)
    carry = np.linalg.solve(Z[0] @ W @ Z[0].T, Z[0] @ W)
    worlds = []
    for _ in range(400):
        wrong = np.zeros((ROWS, 4))
        for j in range(4):
            t, d, v = tension[:, j], friction[:, j], speed[:, j]
            rates = np.gradient(t), np.gradient(command[:, j])
            X = np.stack([np.ones(ROWS), t, t**2, t**3, *rates, d, d * (1 - d**2), v], axis=-1)
            X = X / np.sqrt(np.mean(X**2, axis=0))
            noise = of_frames[j] * rng.normal(size=FRAMES)
            wrong[:, j] = X @ np.linalg.lstsq(X[frames], noise, rcond=1e-8)[0]
        worlds.append(wrong @ carry.T)
    made = np.std(worlds, axis=0)
    assert np.sqrt(np.mean(claimed**2) / np.mean(made**2)) == pytest.approx(1.0, abs=0.14)
    assert np.corrcoef(claimed.ravel(), made.ravel())[0, 1] > 0.9


def test_a_cable_that_is_left_out_moves_nothing_and_vision_tells_what_cables_do_not() -> None:
    """With one cable of four, two directions of the joints are vision's alone: its errors do not enter them."""
    Z = levers()
    own = np.where(np.arange(4) == 2, OWN, np.inf)
    errors = ElongationErrors(of_mean=np.full(4, 1e-6), own=own, vision=np.full(3, NOISE))
    patterns = np.array(errors.of_angles(Z, *motion()))
    assert len(patterns) == 9
    along = Z[0, :, 2] / np.linalg.norm(Z[0, :, 2])
    across = patterns - (patterns @ along)[..., None] * along
    assert np.abs(across).max() < 1e-3 * np.abs(patterns).max()
    assert np.isfinite(patterns).all()


def test_angles_by_vision_alone_have_none() -> None:
    data, Z = recording(2000), np.ones((2000, 3, 4))
    fused = {**data.clock, "state": {"method": "fused", "cable_error_m": [1e-6, None, 1e-6, 1e-6]}}
    of_vision = replace(data, clock={**data.clock, "state": {"method": "vision"}})
    assert ElongationErrors.of(of_vision, Z) is None
    found = ElongationErrors.of(replace(data, clock=fused), Z)
    assert found is not None
    assert np.isinf(found.own).tolist() == [False, True, False, False]
    sigma = np.sqrt(np.mean(data.angles.matrix("sigma") ** 2, axis=0))
    assert found.vision == pytest.approx(sigma)
    # of every cable the same, as all its levers are: a mean of F frames errs by the root of F less
    assert found.of_mean == pytest.approx(np.full(4, np.linalg.norm(sigma) / np.sqrt(len(data.angles.time))))
