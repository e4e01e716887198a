"""Every effect does to the residuals what its columns say, and nothing where its numbers are zero."""

import numpy as np
import pytest

from identification.dataset import DataSet
from identification.diagnosis.cause import Cause, believed
from identification.diagnosis.comparison import Comparison, compare
from identification.diagnosis.effects import EFFECTS
from identification.diagnosis.hypothesis import Hypothesis, as_described
from identification.diagnosis.nuisances import adjusted, errors
from identification.diagnosis.point import Point, point, read_all, sought
from identification.whitening import Whitener
from mechanism.arm import arm_of
from tests.identification.test_estimates import CA, FS, K, recording


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000)


@pytest.fixture(scope="module")
def at(data: DataSet) -> Point:
    h = as_described(data.neck)
    u = sought(h, 1)
    p = u.start()
    for name, value in {"fs": FS, "k": K, "ca": CA}.items():
        p[u.slots[name, None]] = value
    return read_at(h, data, p)


def read_at(h: Hypothesis, data: DataSet, p: np.ndarray) -> Point:
    late = np.zeros(1)
    return point(h, read_all(h, [data], late), p, late)


@pytest.mark.parametrize("name", EFFECTS)
def test_columns_are_what_an_effect_does(name: str, at: Point, data: DataSet) -> None:
    """Against residuals of the recording read anew with the effect in the hypothesis, to a quarter of the change.

    Laws act on elongations that the motors tell, and forces are filtered here but not where only geometry changes: so not exactly.
    """
    effect, arm, h = EFFECTS[name], at.hypothesis.arm, at.hypothesis
    place, shape = at.places[0], effect.shapes[0]
    columns = effect.columns(place, shape)
    sizes = effect.sizes(arm)
    assert columns.shape[2] == len(sizes)
    where = effect.wheres(arm)[-1]
    k = where.columns[0]
    cause = Cause(effect, where, np.array([sizes[c] if c == k else 0.0 for c in where.columns]), dict(shape))
    changed = read_at(believed(h, [cause]), data, at.p).places[0].rows.residual - place.rows.residual
    expected = columns[..., k] * sizes[k]
    if name == "cable_slack":  # never slack here
        assert not expected.any()
        return
    assert np.abs(expected).max() > 0
    # vision's noise shakes a cable's memory of its way, which told elongations keep
    part = 0.6 if name == "cable_hysteresis" else 0.25
    for channel in range(len(changed)):
        scale = np.abs(changed[channel]).max()
        if scale > 0.05 * np.abs(changed[: arm.M] if channel < arm.M else changed[arm.M :]).max():
            assert np.std(changed[channel] - expected[channel]) < part * np.std(changed[channel]) + 1e-12


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_of_nothing_changes_nothing(name: str, at: Point, data: DataSet) -> None:
    effect = EFFECTS[name]
    where = effect.wheres(at.hypothesis.arm)[0]
    cause = Cause(effect, where, np.zeros(len(where.columns)), dict(effect.shapes[0]))
    there = read_at(believed(at.hypothesis, [cause]), data, at.p)
    floor = 1e-6 * np.abs(at.places[0].rows.residual).max()
    np.testing.assert_allclose(there.places[0].rows.residual, at.places[0].rows.residual, atol=max(floor, 2e-4))


def test_a_fit_is_least_squares_with_what_is_known(at: Point) -> None:
    """Against stacked rows and numpy, where no nuisance meets its wall; with twice the residual some do, and stay there."""
    now = compared(at)
    fit = now.fit(now.groups[0].columns[:4])
    trusted = at.places[0].trust[..., None] * now.matrix[0]
    matrix, residual = trusted[..., fit.columns].reshape(-1, len(fit.columns)), trusted[..., -1].ravel()
    known = np.isfinite(now.sigma[fit.columns])
    prior = np.diag(1 / now.sigma[fit.columns])[known]
    right = np.concatenate([-residual, (now.mean / now.sigma)[fit.columns][known]])
    scale = np.linalg.norm(np.vstack([matrix, prior]), axis=0)
    best, *_ = np.linalg.lstsq(np.vstack([matrix, prior]) / scale, right, rcond=1e-10)
    if np.abs((best / scale)[now.base : now.base + len(now.nuisances)]).max() < 3.4:
        loss = float(np.sum((np.vstack([matrix, prior]) @ (best / scale) - right) ** 2))
        assert fit.loss == pytest.approx(loss, rel=1e-5)
    nuisances = fit.numbers[now.base : now.base + len(now.nuisances)]
    assert np.abs(nuisances).max() <= 3.4 * (1 + 1e-9)


def test_numbers_taken_as_given_are_as_if_subtracted(at: Point) -> None:
    now = compared(at)
    numbers = np.random.default_rng(0).normal(size=len(now.sigma)) * (np.arange(len(now.sigma)) >= now.base)
    shifted = now.shifted(numbers)
    flat = (at.places[0].trust * (now.matrix[0][..., -1] + now.matrix[0][..., :-1] @ numbers)).ravel()
    assert shifted.table[-1, -1] == pytest.approx(float(flat @ flat), rel=1e-9)


def test_a_description_is_adjusted_where_its_nuisances_say(data: DataSet) -> None:
    neck = adjusted(data.neck, ("L 2", "top_mass 3", "drum 1"), np.array([1.0, -1.0, 2.0]))
    arm, was = arm_of(neck), data.arm
    np.testing.assert_allclose(arm.L / was.L, [1, 1.006, 1])
    np.testing.assert_allclose(arm.top_mass / was.top_mass, [1, 1, 0.994])
    np.testing.assert_allclose(arm.drum / was.drum, [1.0024, 1, 1, 1])


def compared(at: Point) -> Comparison:
    plain = Whitener(np.ones((7, 1)))
    return compare(at, (), [(EFFECTS["viscous_friction"], {})], errors(at), plain)
