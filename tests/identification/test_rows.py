"""The rows of a fit: filtering, memory of cables, columns, whitening."""

from typing import Any

import numpy as np
import pytest

from identification.block_covariance import BlockSums, jackknife_influence, student_inflated
from identification.cable_memory import memory_states
from identification.dataset.half_row_speeds import HalfRowSpeeds
from identification.decimation import CUTOFF_HZ, decimating_filter
from identification.residuals import residual_rows
from identification.signals import Signals
from identification.unknowns import unknowns
from identification.whitening import fit_whitener
from mechanism.arm import Arm, arm_of
from mechanism.description import read_neck
from mechanism.laws import LAWS, CableMotion
from mechanism.machine import Machine
from tests.identification.test_estimates import FILE

STEP = 0.002


def arm() -> Arm:
    return arm_of(read_neck(FILE))


def signals(rng: np.random.Generator, count: int = 1000) -> Signals:
    """Smooth signals that no arm made: columns must be right for any."""
    time = STEP * np.arange(count, dtype=float)

    def some(width: int, size: float) -> np.ndarray:
        return size * np.sin(np.outer(time, rng.uniform(2, 9, width)) + rng.uniform(0, 6, width))

    a = arm()
    known: dict[str, Any] = {
        name: some(3, 1.0) for name in ("alpha", "alpha_d", "alpha_dd", "load", "vision_alpha", "vision_alpha_d")
    }
    known |= {"theta_d": some(4, 20.0), "f": 50 + some(4, 20.0), "inertial": some(4, 1.0)}
    known |= {"wraps": np.stack([1 + some(4, 0.3) for _ in range(6)], axis=1)}
    known |= {"theta": some(4, 5.0), "theta_dd": some(4, 99.0)}
    known |= {"length": 1 + some(4, 0.1), "x": 5e-3 + some(4, 3e-3), "x_d": some(4, 2e-2)}
    half = some(4, 0.5) * np.array([-1.0, 1.0])[:, None, None]
    known["speeds"] = HalfRowSpeeds(known["theta_d"] + half, np.full(4, 10.0), np.full(4, 1e-3))
    Z = 0.03 + 0.01 * rng.normal(size=(3, 4)) + np.zeros((count, 1, 1))
    return Signals(
        arm=a,
        time=time,
        Z=Z,
        low_pass=decimating_filter(STEP, np.ones(count, bool)),
        clock_sigma=(0.0, 0.0),
        relaxed_clock_sigma=0.0,
        angle_sigma=np.zeros(3),
        **known,
    )


def test_low_pass_keeps_the_motion_and_drops_what_would_fold_back() -> None:
    """Half a cutoff passes within 1 %, two cutoffs are down to 1 %, and rows are where `kept` says."""
    time = STEP * np.arange(5000)
    keep = decimating_filter(STEP, np.ones(5000, bool))
    for hertz, gain in ((CUTOFF_HZ / 2, 1.0), (2 * CUTOFF_HZ, 0.0)):
        wave = np.sin(2 * np.pi * hertz * time)
        np.testing.assert_allclose(keep(wave), gain * wave[keep.kept], atol=0.01)


@pytest.mark.parametrize(("step", "count"), [(0.002, 1000), (0.002, 1009), (0.00195, 999), (0.03, 200), (0.002, 190)])
def test_low_pass_in_blocks_is_the_filter(step: float, count: int) -> None:
    """Whatever the rate and wherever the last block ends; real or complex; a recording shorter than the filter has no rows."""
    keep, values = decimating_filter(step, np.ones(count, bool)), np.random.default_rng(0).normal(size=(count, 2))
    expected = [np.convolve(v, keep.taps)[len(keep.taps) // 2 :][keep.kept] for v in values.T]
    np.testing.assert_allclose(keep(values.T), expected, atol=1e-14)
    np.testing.assert_allclose(keep(np.exp(1j * values[:, 0])).imag, keep(np.sin(values[:, 0])), atol=1e-14)


def test_low_pass_looks_at_no_row_that_is_not_known() -> None:
    known = np.ones(5000, bool)
    known[2000:2100] = known[3000] = False
    values = np.where(known, 1.0, np.nan)
    out = decimating_filter(STEP, known)(values)
    np.testing.assert_allclose(out, 1.0)
    assert len(out) < len(decimating_filter(STEP, np.ones(5000, bool)).kept)


def test_what_laws_remember_is_affine_in_itself() -> None:
    """`remembered` rests on it: the drift at 2 z is as far from that at z as that is from the one at 0."""
    rng = np.random.default_rng(0)
    at = CableMotion(rng.normal(size=(9, 4)), rng.normal(size=(9, 4)), np.ones((9, 4)), arm(), np.zeros((9, 4)))
    for law in LAWS.values():
        if law.states:
            p = {term.name: np.full(4, term.size) for term in law.terms}
            z = rng.normal(size=(9, 4, law.states))
            a, b, c = (law.memory_rate(p, at, k * z) for k in (0, 1, 2))
            np.testing.assert_allclose(c - b, b - a, atol=1e-9 * np.abs(b).max())


def test_creep_is_remembered_as_its_exact_solution() -> None:
    """A steady rate v: z = km v tau (1 - exp(-t/tau))."""
    at = CableMotion(np.zeros((3000, 4)), np.full((3000, 4), 1e-3), np.ones((3000, 4)), arm(), np.zeros((3000, 4)))
    z = memory_states(Machine(arm(), ("cable_creep",), {"km": np.full(4, 500.0), "tau": np.array([2.0])}), at, STEP)
    expected = 500 * 1e-3 * 2.0 * (1 - np.exp(-STEP * np.arange(3000) / 2.0))
    np.testing.assert_allclose(z[:, 1, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("elastic", [("linear_cable", "cable_hardening", "cable_toe", "cable_creep", "cable_hysteresis"),
                                     ("youngs_modulus",), ("youngs_modulus_in_pose",)])  # fmt: skip
def test_columns_are_the_derivatives_of_the_residuals(elastic: tuple[str, ...]) -> None:
    """Central differences of the whole residual, each entry alone, with every law of friction taking part."""
    rng = np.random.default_rng(1)
    laws = ("dry_friction", "viscous_friction", "stribeck_friction", "pulley_friction", "joint_friction", *elastic)
    s, u = signals(rng), unknowns(arm(), laws, 2)
    p = u.start() + u.size * rng.uniform(0.5, 1.0, len(u.entries))
    J = residual_rows(s, u, p, 1).jacobian
    for place, entry in enumerate(u.entries):
        h = 1e-3 * entry.term.size * np.eye(len(p))[place]
        slope = (residual_rows(s, u, p + h, 1).residual - residual_rows(s, u, p - h, 1).residual) / (2 * h[place])
        # forward differences over a thousandth of a term's size: off by about a thousandth; delays sample straight pieces
        near = 2e-2 if entry.term.name == "delay" else 5e-3
        np.testing.assert_allclose(J[:, :, place], slope, atol=near * max(np.abs(slope).max(), 1e-12))
        if entry.recording == 0:
            assert not J[:, :, place].any()


def test_whitening_leaves_nothing_that_one_row_tells_of_the_next() -> None:
    """An autoregression of order 2, twice, with a gap: lags 1 to 3 below three standard errors, unit variance, and no row
    just after a gap counts."""
    rng = np.random.default_rng(2)
    e = rng.normal(size=(1, 6000))
    x = np.zeros_like(e)
    for i in range(2, 6000):
        x[:, i] = 1.2 * x[:, i - 1] - 0.5 * x[:, i - 2] + 3 * e[:, i]
    starts = np.zeros(6000, bool)
    starts[[0, 2500]] = True
    white = fit_whitener([x], [starts])(x, starts)[0]
    assert not white[:6].any()
    assert not white[2500:2506].any()
    assert np.std(white) == pytest.approx(1, abs=0.03)
    for lag in (1, 2, 3):
        assert abs(np.mean(white[lag:] * white[:-lag])) < 3 / np.sqrt(6000)


def test_a_sigma_that_few_blocks_tell_is_wider() -> None:
    """One number from sixty blocks of which five tell nearly all: errors over sigmas spread by one, and not if blocks count alike.

    Margins are three standard errors of the spread of 4000 normal numbers.
    """
    rng = np.random.default_rng(0)
    told = np.where(np.arange(60) < 5, 1.0, 0.05)
    blunt, wide = [], []
    for pull in np.sqrt(told) * rng.normal(size=(4000, 60)):
        value = pull.sum() / told.sum()
        left = BlockSums((pull - told * value)[:, None], told[:, None, None])
        alone = jackknife_influence(left, told.sum(keepdims=True)[:, None], np.ones(1, bool), np.ones(1))
        blunt.append(value / np.sqrt(np.sum(alone**2)))
        wide.append(value / np.sqrt(np.sum(student_inflated(alone) ** 2)))
    margin = 3 / np.sqrt(2 * 4000)
    assert abs(np.std(wide) - 1) < margin
    assert np.std(blunt) > 1 + margin
