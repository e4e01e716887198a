"""Every effect does to the residuals what its columns say, and nothing where its numbers are zero."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from diagnosis.cause import Cause, with_causes
from diagnosis.compare import compare
from diagnosis.comparison import FOLDS, Comparison
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis, as_described
from diagnosis.linearisation import Linearisation, base_unknowns, corrected_signals, linearise
from diagnosis.noise_ensemble import noise_whitener
from diagnosis.nuisances import nuisances_at
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from identification.fitting import segment_starts
from identification.residuals import ResidualRows
from identification.whitening import Whitener
from tests.identification.test_estimates import CA, FS, K, recording


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000)


@pytest.fixture(scope="module")
def at(data: DataSet) -> Linearisation:
    h = as_described(data.neck)
    u = base_unknowns(h, 1)
    p = u.start()
    for name, value in {"fs": FS, "k": K, "ca": CA}.items():
        p[u.slots[name, None]] = value
    return read_at(h, data, p)


def read_at(h: Hypothesis, data: DataSet, p: np.ndarray) -> Linearisation:
    """p: of the base model; what cables remember in the beginning is nothing."""
    late, p = np.zeros(1), base_unknowns(as_described(data.neck), 1).carried(p, base_unknowns(h, 1))
    return linearise(h, corrected_signals(h, [data], late), p, late)


@pytest.mark.parametrize("name", EFFECTS)
def test_columns_are_what_an_effect_does(name: str, at: Linearisation, data: DataSet) -> None:
    """Against residuals of the recording read anew with the effect in the hypothesis, to a quarter of the change.

    Laws act on elongations that the motors tell, and forces are filtered here but not where only geometry changes: so not exactly.
    """
    effect, arm, h = EFFECTS[name], at.hypothesis.arm, at.hypothesis
    recording_at, shape = at.recordings[0], effect.start_shapes[0]
    columns = effect.columns(recording_at, shape)
    sizes = effect.sizes(arm)
    assert columns.shape[2] == len(sizes)
    where = effect.placements(arm)[-1]
    k = where.columns[0]
    cause = Cause(effect, where, np.array([sizes[c] if c == k else 0.0 for c in where.columns]), dict(shape))
    changed = read_at(with_causes(h, [cause]), data, at.p).recordings[0].rows.residual - recording_at.rows.residual
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
def test_an_effect_of_nothing_changes_nothing(name: str, at: Linearisation, data: DataSet) -> None:
    effect = EFFECTS[name]
    where = effect.placements(at.hypothesis.arm)[0]
    cause = Cause(effect, where, np.zeros(len(where.columns)), dict(effect.start_shapes[0]))
    there = read_at(with_causes(at.hypothesis, [cause]), data, at.p)
    floor = 1e-6 * np.abs(at.recordings[0].rows.residual).max()
    np.testing.assert_allclose(there.recordings[0].rows.residual, at.recordings[0].rows.residual, atol=max(floor, 2e-4))


@pytest.mark.parametrize("louder", [1.0, 30.0])
def test_a_fit_is_bounded_least_squares_with_what_is_known(louder: float, at: Linearisation) -> None:
    """Against stacked rows and scipy; where much more than noise is left what is known counts for as many times more."""
    comparison = compared(louder_by(at, louder))
    fit = comparison.fit(comparison.groups[0].columns[:4])
    use, sigma = fit.columns, comparison.prior_sigma / np.sqrt(comparison.temper)
    assert (comparison.temper > 2) == (louder > 1)
    # of a whitener that leaves rows as they are
    weighted = comparison.matrices[0] / np.sqrt(1 + at.recordings[0].input_variance)[..., None]
    known = np.isfinite(sigma[use])
    stacked = np.vstack([weighted[..., use].reshape(-1, len(use)), np.diag(1 / sigma[use])[known]])
    right = np.concatenate([-weighted[..., -1].ravel(), (comparison.prior_mean / sigma)[use][known]])
    scale = np.linalg.norm(stacked, axis=0)
    best = lsq_linear(
        stacked / scale, right, (comparison.lower_bounds[use] * scale, comparison.upper_bounds[use] * scale), tol=1e-14
    )
    assert fit.loss == pytest.approx(2 * best.cost, rel=1e-5)


def test_friction_that_would_drive_is_fitted_as_next_to_none(at: Linearisation, data: DataSet) -> None:
    """What the recording would like best goes down by five sizes; by chance it may go down by one."""
    effect = EFFECTS["joint_friction"]
    where = effect.placements(at.hypothesis.arm)[0]
    cause = Cause(effect, where, np.zeros(len(where.columns)), dict(effect.start_shapes[0]))
    with_it = read_at(with_causes(at.hypothesis, [cause]), data, at.p)
    (one,) = with_it.recordings
    driven = ResidualRows(one.rows.residual + 5 * cause.columns(one)[..., 0], one.rows.jacobian)
    driving = replace(with_it, recordings=(replace(one, rows=driven),))
    comparison = compare(driving, [cause], (), nuisances_at(driving), Whitener(np.ones((7, 1))))
    dry = comparison.cause_columns[0]
    unbounded = replace(comparison, lower_bounds=np.full_like(comparison.lower_bounds, -np.inf)).fit()
    assert unbounded.numbers[unbounded.columns == dry] < -3
    assert comparison.fit().numbers[comparison.fit().columns == dry] == pytest.approx(-1)


def test_a_block_is_judged_by_a_fit_to_the_other_folds(at: Linearisation) -> None:
    comparison = compared(at)
    columns = comparison.groups[0].columns
    losses, fold = comparison.block_losses(columns), comparison.folds(columns)
    others = replace(comparison, block_products=comparison.block_products * (fold != 2)[:, None, None])
    fit = others.fit(columns)
    y, where = np.append(fit.numbers, 1.0), np.append(fit.columns, len(comparison.prior_sigma))
    expected = [y @ block[np.ix_(where, where)] @ y for block in comparison.block_products[fold == 2]]
    np.testing.assert_allclose(losses[fold == 2], expected, rtol=1e-6)
    # and that is more than what a fit to all of them leaves
    assert losses.sum() > comparison.fit(columns).loss - float(
        np.sum((comparison.fit(columns).numbers / comparison.prior_sigma[fit.columns]) ** 2)
    )


def test_what_few_blocks_tell_is_never_judged_without_them_all(at: Linearisation) -> None:
    """Two episodes that tell all of a cause, as many blocks apart as there are folds."""
    comparison = compared(at)
    blocks = np.repeat(comparison.block_products[:1], 4 * FOLDS, axis=0)
    columns = comparison.groups[0].columns[:1]
    blocks[:, columns, columns] = 0.0
    seen = [3, 3 + FOLDS]
    blocks[seen, columns, columns] = [5.0, 4.0]
    many = replace(comparison, block_products=blocks)
    usual, spread = many.folds(), many.folds(columns)
    assert usual[seen[0]] == usual[seen[1]]
    assert spread[seen[0]] != spread[seen[1]]
    others = np.setdiff1d(np.arange(len(blocks)), seen)
    np.testing.assert_array_equal(spread[others], usual[others])


def test_what_chance_takes_is_as_rare_as_it_is_said_to_be(at: Linearisation) -> None:
    """Noise that was not among the draws: the most that any effect explains of it is beyond one in ten worlds of ten."""
    recording_at, rng = at.recordings[0], np.random.default_rng(5)

    def noise() -> np.ndarray:
        drawn = recording_at.signals.low_pass(rng.normal(size=(7, len(recording_at.signals.time))))
        return np.array([0.3] * 4 + [1e-3] * 3)[:, None] * drawn / drawn.std()

    draws = [noise() for _ in range(4)]
    whiten = noise_whitener([draws], [segment_starts(recording_at.signals)], 4)
    asked = [
        (EFFECTS[name], EFFECTS[name].start_shapes[0]) for name in ("viscous_friction", "actuator_gain", "base_tilt")
    ]
    known = nuisances_at(at)
    alarms, worlds = 0, 60
    for _ in range(worlds):
        there = replace(at, recordings=(replace(recording_at, rows=ResidualRows(noise(), recording_at.rows.jacobian)),))
        comparison = compare(there, (), asked, known, whiten, [draws])
        choices = [group.columns for group in comparison.groups]
        limit = np.quantile(comparison.chance_gains(choices, np.random.default_rng(0), 400), 0.9)
        most = max(comparison.fit().loss - comparison.fit(columns).loss for columns in choices)
        alarms += bool(most > limit)
    # binomial: 6 expected, 14 and more once in five hundred
    assert alarms < 14
    assert alarms > 0


def louder_by(at: Linearisation, factor: float) -> Linearisation:
    rows = at.recordings[0].rows
    return replace(
        at, recordings=(replace(at.recordings[0], rows=ResidualRows(factor * rows.residual, rows.jacobian)),)
    )


def test_numbers_taken_as_given_are_as_if_subtracted(at: Linearisation) -> None:
    comparison = compared(at)
    numbers = np.random.default_rng(0).normal(size=len(comparison.prior_sigma)) * (
        np.arange(len(comparison.prior_sigma)) >= comparison.base_count
    )
    shifted = comparison.with_fixed(numbers)
    left = comparison.matrices[0][..., -1] + comparison.matrices[0][..., :-1] @ numbers
    flat = (left / np.sqrt(1 + at.recordings[0].input_variance)).ravel()
    assert shifted.products[-1, -1] == pytest.approx(float(flat @ flat), rel=1e-9)


def test_a_hypothesis_is_adjusted_where_its_nuisances_say(at: Linearisation, data: DataSet) -> None:
    nuisances, numbers = nuisances_at(at), {"L of mechanism 2": 1.0, "mass of top bar 3": -1.0, "drum 1": 2.0}
    of_drawing = [numbers.get(number.name, 0.0) for number in nuisances.drawing]
    of_curve = np.full(nuisances.count - len(of_drawing) - 4, 2.0)
    found = nuisances.adjusted(at.hypothesis, np.array([*of_drawing, 0.0, 3.0, 0.0, 0.0, *of_curve]))
    arm, was = found.arm, data.arm
    np.testing.assert_allclose(arm.L / was.L, [1, 1.002, 1])
    np.testing.assert_allclose(arm.top_mass / was.top_mass, [1, 1, 0.97])
    np.testing.assert_allclose(arm.drum / was.drum, [1.004, 1, 1, 1])
    # the markers of bar 1 turned: the joint below it reads too much, the one above too little
    np.testing.assert_allclose(np.degrees(found.angle_error), [0.9, -0.9, 0.0])
    # friction keeps its curve
    np.testing.assert_allclose(found.departures, [*of_drawing, 0.0, 3.0, 0.0, 0.0, *(0 * of_curve)])


def test_columns_of_nuisances_are_what_the_arm_does_that_has_them(at: Linearisation, data: DataSet) -> None:
    """Against residuals computed with the other arm; the column of a motor's inertia was once 6 % off, by a filter."""
    nuisances, before = nuisances_at(at), at.recordings[0].rows.residual
    for k, number in enumerate(nuisances.drawing):
        neck = number.moved(at.hypothesis.neck, number.sigma)
        there = read_at(replace(at.hypothesis, neck=neck), data, at.p).recordings[0].rows.residual
        changed, column = there - before, nuisances.arm_columns[0][..., k]
        loudest = int(np.argmax(np.std(changed, axis=1) / np.std(before, axis=1)))
        part = 0.02 if number.kind == "motor_inertia" else 0.25
        assert np.std(changed[loudest] - column[loudest]) < part * np.std(changed[loudest]) + 1e-9, number.name


def test_a_drum_known_to_a_tolerance_leaves_forces_known_to_as_much(at: Linearisation, data: DataSet) -> None:
    """The column of motor 3's forces is what a log does that says .2 % more of them."""
    motors, state = at.hypothesis.arm.M, data.state
    column = nuisances_at(at).arm_columns[0][..., -motors + 2]
    louder = replace(data, state=Series(state.time, {**state.columns, "f3": 1.002 * state.columns["f3"]}))
    changed = read_at(at.hypothesis, louder, at.p).recordings[0].rows.residual - at.recordings[0].rows.residual
    assert np.std(changed[2]) > 0
    # friction under a tension that follows from the force is beside it
    assert np.std(changed - column, axis=1) == pytest.approx(0 * changed[:, 0], abs=0.02 * float(np.std(changed[2])))


def test_a_drum_that_forces_are_torques_over_is_a_gain_as_well(at: Linearisation, data: DataSet) -> None:
    """What a drum 2 % too small does beside the described one is what it does with a log that says 2 % too little of its force."""
    h, state = at.hypothesis.with_forces_as_drums(), data.state
    small, amounts = -0.02, np.array([0.0, 0.0, -0.02, 0.0])
    there = EFFECTS["drum_radius"].added_to(h, amounts, {})
    assert there.values["g"][2] == pytest.approx(small)
    assert EFFECTS["drum_radius"].added_to(at.hypothesis, amounts, {}).laws == at.hypothesis.laws
    louder = replace(data, state=Series(state.time, {**state.columns, "f3": state.columns["f3"] / (1 + small)}))
    plain = EFFECTS["drum_radius"].added_to(at.hypothesis, amounts, {})
    of_both, of_louder = (
        read_at(which, log, at.p).recordings[0].rows.residual for which, log in ((there, data), (plain, louder))
    )
    before = at.recordings[0].rows.residual
    assert np.std(of_both - of_louder) < 1e-3 * np.std(of_both - before)
    column = EFFECTS["drum_radius"].columns(read_at(h, data, at.p).recordings[0], {})[..., 2]
    assert np.std(of_both - before - small * column) < 0.25 * np.std(of_both - before)


def test_a_motors_inertia_changes_what_rubs_on_pulleys(at: Linearisation, data: DataSet) -> None:
    """Inertia takes from a cable's tension, and so from its friction: without that the arm's equation was left with newtons."""
    rubbing = at.hypothesis.with_law("pulley_friction", {"mu": np.full(4, 0.02), "cm": np.array([0.5])})
    there = read_at(rubbing, data, at.p)
    nuisances, motors = nuisances_at(there), at.hypothesis.arm.M
    inertias = [k for k, number in enumerate(nuisances.drawing) if number.kind == "motor_inertia"]
    assert len(inertias) == motors
    for k in inertias:
        number = nuisances.drawing[k]
        heavier = read_at(replace(rubbing, neck=number.moved(rubbing.neck, number.sigma)), data, at.p)
        changed = (heavier.recordings[0].rows.residual - there.recordings[0].rows.residual)[motors:]
        column = nuisances.arm_columns[0][motors:, :, k]
        assert np.std(changed - column) < 0.02 * np.std(changed)


def test_what_rubs_along_the_arm_does_not_change_with_the_cables_ways(data: DataSet) -> None:
    """A millimetre of a pulley's radius changes newtons of what cables pull by their elongation, not what motors tell of it.

    By elongations the arm's equations seemed to lose another torque on the way with each number of the drawing, half of what that
    does. What turns over between two kept rows, here and in a joint, was not filtered as residuals are.
    """
    h = as_described(data.neck)
    along = {"mu": np.zeros(h.arm.M), "ma": np.full(h.arm.M, 0.02), "vp": np.array([1e-3]), "wm": np.zeros(1)}
    rubbing = read_at(h.with_law("pulley_friction", along), data, base_unknowns(h, 1).start())
    nuisances, arm_rows = nuisances_at(rubbing), slice(h.arm.M, None)
    pulleys = [k for k, number in enumerate(nuisances.drawing) if number.kind == "pulley"]
    assert pulleys
    for k in pulleys:
        number = nuisances.drawing[k]
        moved = replace(rubbing.hypothesis, neck=number.moved(h.neck, number.sigma))
        there = read_at(moved, data, rubbing.p)
        changed = (there.recordings[0].rows.residual - rubbing.recordings[0].rows.residual)[arm_rows]
        left = changed - nuisances.arm_columns[0][arm_rows, :, k]
        assert np.std(left) < 0.15 * np.std(changed), number.name


def test_frames_that_are_late_show_joint_friction_late(data: DataSet) -> None:
    """A joint's friction turns over within less than a kept row, and where it does moves with the clock."""
    h = as_described(data.neck)
    sticking = {"cj": np.full(3, 0.02), "dj": np.zeros(3), "vj": np.array([0.02]), "nj": np.array([2.0])}
    rubbing = h.with_law("joint_friction", sticking)
    p = base_unknowns(rubbing, 1).start()
    lag = 2e-3
    there, late = (
        linearise(rubbing, corrected_signals(rubbing, [data], at), p, at) for at in (np.zeros(1), np.array([lag]))
    )
    changed = (late.recordings[0].rows.residual - there.recordings[0].rows.residual)[h.arm.M :]
    sensitivity = there.recordings[0].sensitivity
    left = changed - sensitivity.residual_change(angle_error=sensitivity.error_of_lag(lag))[h.arm.M :]
    assert np.std(left) < 0.2 * np.std(changed)


@pytest.mark.parametrize("name", ["x0", "k", "ca", "fs"])
def test_what_motors_rub_by_does_not_change_with_the_cables(name: str, data: DataSet) -> None:
    """The tension that friction on pulleys depends on is the motors': a cable's numbers do nothing to the arm's equations.

    What dry friction does to that tension is left out, a fiftieth of its column. Where the cables' columns said that they do, fits
    with this friction went to where nothing is least: motors were left with 2 to 7 times noise in recordings not fitted.
    """
    h = as_described(data.neck)
    h = h.with_law(
        "pulley_friction",
        {"mu": np.full(h.arm.M, 0.01), "ma": np.zeros(h.arm.M), "vp": np.array([1e-3]), "wm": np.zeros(1)},
    )
    u = base_unknowns(h, 1)
    place = u.slots[name, 0 if name == "x0" else None].start
    change = 0.01 * u.size[place] * np.eye(len(u.size))[place]
    rows = [read_at(h, data, u.start() + side * change).recordings[0].rows for side in (1, 0, -1)]
    slope = (rows[0].residual - rows[2].residual) / (2 * change[place])
    column = rows[1].jacobian[..., place]
    lever = 0.05
    of_motor = float(np.sqrt(np.mean(slope[: h.arm.M] ** 2)))
    left = np.sqrt(np.mean((column - slope)[h.arm.M :] ** 2))
    assert left < (0.02 if name == "fs" else 1e-4) * lever * of_motor


def compared(at: Linearisation) -> Comparison:
    plain = Whitener(np.ones((7, 1)))
    return compare(at, (), [(EFFECTS["viscous_friction"], {})], nuisances_at(at), plain)
