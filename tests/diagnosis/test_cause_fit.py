"""Where a fit begins, and where it ends."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis import cause_search
from diagnosis.cause import Cause
from diagnosis.cause_fit import MAX_START_DELAY_S, CauseFitter
from diagnosis.cause_parameters import parameters_of
from diagnosis.cause_search import search_causes
from diagnosis.descent import last_fit
from diagnosis.drawing_findings import drawing_findings
from diagnosis.effects import EFFECTS
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import with_laws_of
from diagnosis.look_alikes import NamedCause
from diagnosis.noise_ensemble import noise_ensemble
from diagnosis.nuisances import MAX_TOLERANCES
from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series, numbered_columns
from mechanism.toleranced_numbers import moved, toleranced_numbers
from tests.identification.test_estimates import recording

LATE_ROWS = 4
"""8 ms: more than forces can be late by what is known of them"""


@pytest.fixture(scope="module")
def stale() -> DataSet:
    """Forces as they were some rows before."""
    data = recording(2000)
    f = data.state.matrix("f")
    held = np.concatenate([np.repeat(f[:1], LATE_ROWS, axis=0), f[:-LATE_ROWS]])
    return replace(data, state=Series(data.state.time, {**data.state.columns, **numbered_columns("f", held)}))


def test_forces_that_are_later_than_expected_are_found_so(stale: DataSet) -> None:
    """A prior without a wall: the fit begins within what is known of delays, and goes where the recording says."""
    stage = CauseFitter(as_described(stale.neck), [noise_ensemble(stale, frame_angles(stale), 0)]).base_model()
    logged_late = -stage.comparison.linearisation.recordings[0].delay
    assert logged_late == pytest.approx(LATE_ROWS * 2e-3, abs=5e-4)
    assert logged_late > MAX_START_DELAY_S


@pytest.mark.parametrize(("name", "least"), [("actuator_lag", 0.0), ("backlash", 0.0), ("joint_friction", -1.0)])
def test_a_step_promises_only_what_it_can_take(name: str, least: float, stale: DataSet) -> None:
    """Friction may come out a little below nothing by chance, a lag or a play may not."""
    arm, effect = as_described(stale.neck).arm, EFFECTS[name]
    everywhere = effect.placements(arm)[0]
    nothing = Cause(effect, everywhere, np.zeros(len(everywhere.columns)), dict(effect.start_shapes[0]))
    np.testing.assert_array_equal(nothing.least_steps(arm), least)
    down = nothing.stepped(np.full(nothing.number_count, least), arm)
    np.testing.assert_allclose(down.amounts, least * effect.sizes(arm)[list(everywhere.columns)])


def test_a_number_that_ended_at_the_end_of_its_range_has_no_sigma() -> None:
    """The fit holds it there: a sigma of what is held would say that it is known to some parts in a million."""
    data = recording(2000)
    fitter = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)])
    effect = EFFECTS["pulley_friction"]
    term = effect.shape_terms[0]
    everywhere = effect.placements(as_described(data.neck).arm)[0]
    sigmas = {}
    for value in (term.low, 3 * term.low):
        cause = Cause(effect, everywhere, np.zeros(len(everywhere.columns)), {term.name: value, "wm": 0.0})
        (numbers,) = parameters_of(fitter.fitted(fitter.base_model().comparison.linearisation, (cause,)))
        (sigmas[value],) = (p.sigma for p in numbers if p.name == term.name)
    assert np.isinf(sigmas[term.low])
    assert np.isfinite(sigmas[3 * term.low])


def test_numbers_of_the_drawing_go_no_further_than_four_tolerances_whatever_is_named() -> None:
    """A spring of 60 % more than described is not the one that was drawn: what it does beyond four tolerances stays above noise.

    Where it went as far as it liked, a motor's offset was given up again: two free lengths at 6.5 tolerances left as little.
    """
    data = recording(2000)
    springs = data.neck.mechanisms[0].springs
    weaker = springs.model_copy(update={"stiffness": springs.stiffness / 1.6})
    first = data.neck.mechanisms[0].model_copy(update={"springs": weaker})
    neck = data.neck.model_copy(update={"mechanisms": (first, *data.neck.mechanisms[1:])})
    wrong = replace(data, neck=neck)
    h = as_described(neck)
    fitter = CauseFitter(h, [noise_ensemble(wrong, frame_angles(wrong), 0)])
    beside = fitter.base_model().comparison.linearisation
    effect = EFFECTS["viscous_friction"]
    viscous = Cause(effect, effect.placements(h.arm)[0], np.zeros(h.arm.M), {})
    for stage in (fitter.base_model(), fitter.fitted(beside, ()), fitter.fitted(beside, (viscous,))):
        for one in (stage, fitter.finished(stage)):
            of_arm = slice(one.comparison.base_count, one.comparison.base_count + one.comparison.nuisances.count)
            assert np.abs(one.fit.numbers[of_arm]).max() == pytest.approx(MAX_TOLERANCES)
            assert one.excess.above_noise
            free = np.full(len(one.comparison.upper_bounds), np.inf)
            anywhere = replace(one.comparison, lower_bounds=-free, upper_bounds=free)
            assert np.abs(anywhere.fit().numbers[of_arm]).max() > MAX_TOLERANCES + 1


def test_weights_of_other_noise_are_told_anew_before_causes_are_chosen() -> None:
    """A fit begins with weights by rough numbers. Of a cable of a fifth of its stiffness there noise seemed 25 times as loud: every
    cause needed to take as much, and the fit stayed at too soft a cable."""
    data = recording(2000, noise_deg=0.03)
    fitter = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)])
    usual = fitter.base_model()
    fitter.whiten = fitter.whiten.rescaled(np.array([1.0, 1.0, 0.2, 1.0, 1.0, 1.0, 1.0]))
    fitter._stages.clear()
    first = fitter.base_model()
    assert first.noise_loss > 1.8 * first.comparison.row_count
    _, anew = fitter.redrawn(first)
    for one, other in ((anew.noise_loss, usual.noise_loss), (anew.surplus, usual.surplus)):
        assert one == pytest.approx(other, abs=0.05 * usual.noise_loss)
    _, same = fitter.redrawn(usual)
    assert same.noise_loss == pytest.approx(usual.noise_loss, rel=0.05)


def test_an_arm_off_its_drawing_is_fitted_about_itself() -> None:
    """Every number of the drawing is off by two tolerances, to one side or the other: straight lines from there miss the arm.

    From where they lead to little is left to move, what was moved counts as off the drawing, and less is left."""
    data = recording(2000, noise_deg=0.01)
    numbers = toleranced_numbers(data.neck)
    sides = np.random.default_rng(1).choice([-2.0, 2.0], len(numbers))
    drawn = moved(data.neck, numbers, [n.sigma * side for n, side in zip(numbers, sides, strict=True)])
    wrong = replace(data, neck=drawn)
    fitter = CauseFitter(as_described(drawn), [noise_ensemble(wrong, frame_angles(wrong), 0)])
    first = fitter.base_model()
    _, about_itself = fitter.redrawn(first)
    before, after = (
        {found.name: (found.value, found.sigma, found.tolerance) for found in drawing_findings(stage)}
        for stage in (first, about_itself)
    )
    assert max(abs(value) / tolerance for value, _, tolerance in after.values()) > 1.5
    for name in before.keys() & after.keys():
        value, sigma, _ = after[name]
        assert value == pytest.approx(before[name][0], abs=sigma), name
    # what is in doubt of friction and forces is no number of the description, and stays where it is
    moved_count = len(first.comparison.nuisances.drawing) + data.neck.N + 1
    of_arm = slice(first.comparison.base_count, first.comparison.base_count + moved_count)
    assert np.abs(first.fit.numbers[of_arm]).max() > 1.5
    assert np.abs(about_itself.fit.numbers[of_arm]).max() < 0.5
    assert about_itself.surplus < first.surplus


def test_a_fit_that_went_astray_begins_again() -> None:
    """Of a hardening cable stiffness, pre-elongation and power make a bent valley: no steps lead out of its far end.

    On arm 1711 of samples/forward_arms such a fit left 4.6 times noise with all right causes named, and hid a base that leans.
    """
    data = recording(2000)
    h = as_described(data.neck)
    ensembles = [noise_ensemble(data, frame_angles(data), 0)]
    fitter = CauseFitter(h, ensembles)
    at = fitter.base_model().comparison.linearisation
    effect = EFFECTS["cable_hardening"]
    (everywhere, *_) = effect.placements(h.arm)
    hardening = Cause(effect, everywhere, np.full(len(everywhere.columns), 5e5), {"nh": 2.0})
    p = at.p.copy()
    p[at.unknowns.slots["k", None]], p[at.unknowns.slots["x0", 0]] = 400.0, 5e-3
    far = with_laws_of(at, h, p)
    led_on, begun_again = fitter.fitted(at, (hardening,)), CauseFitter(h, ensembles).fitted(far, (hardening,))
    assert not led_on.is_astray
    assert begun_again.surplus == pytest.approx(led_on.surplus, abs=2.0)


def test_a_number_that_nothing_tells_stays_where_steps_ended() -> None:
    """The speed over which dry friction turns over is all but lost beside bends that hold it: a straight step leads anywhere.

    On arm 446 of samples/forward_arms it led to a hundredth of it, and what that does to another recording was taken for noise.
    """
    data = recording(2000)
    h = as_described(data.neck)
    stage = CauseFitter(h, [noise_ensemble(data, frame_angles(data), 0)]).base_model()
    comparison, u = stage.comparison, stage.comparison.linearisation.unknowns
    place, stiffness = u.slots["cm", None].start, u.slots["k", None].start
    faint = np.ones(comparison.block_products.shape[1])
    faint[place] = 1e-6
    untold = replace(comparison, block_products=comparison.block_products * faint[:, None] * faint)
    free = untold.fit().numbers * u.size[place]
    assert abs(free[place]) > 0.9 * stage.comparison.linearisation.p[place]
    kept = last_fit(untold).numbers
    assert abs(kept[place]) < 1e-6
    assert kept[stiffness] == pytest.approx(untold.with_held(np.array([place])).fit().numbers[stiffness])
    # what is told takes its step
    np.testing.assert_allclose(last_fit(comparison).numbers, comparison.fit().numbers)


def test_a_cause_that_no_amount_tells_is_none_where_nothing_is_above_noise(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction that is nothing within its sigmas, or that would drive, is not told; a motor's gain may be less than it was.

    Friction that bends first was named alone on two of 87 clean arms, with amounts of which the largest were two sigma below zero.
    """
    data = recording(2000)
    h = as_described(data.neck)
    ensembles = [noise_ensemble(data, frame_angles(data), 0)]
    fitter = CauseFitter(h, ensembles)
    first = fitter.base_model()
    assert not first.excess.above_noise

    def stage_with(name: str) -> FitStage:
        effect = EFFECTS[name]
        (everywhere, *_) = effect.placements(h.arm)
        cause = Cause(effect, everywhere, np.zeros(len(everywhere.columns)), {})
        return fitter.fitted(first.comparison.linearisation, (cause,))

    def untold_at(stage: FitStage, sigmas: float) -> bool:
        (cause,), (sigma,) = stage.causes, stage.sigma_of_causes
        return replace(stage, causes=(replace(cause, amounts=sigmas * sigma),)).untold == (0,)

    viscous, gain = stage_with("viscous_friction"), stage_with("actuator_gain")
    assert [untold_at(viscous, by) for by in (-10.0, 0.0, 10.0)] == [True, True, False]
    assert [untold_at(gain, by) for by in (-10.0, 0.0, 10.0)] == [False, True, False]
    assert viscous.untold == (0,)
    # what is left above noise widens sigma, as it is told
    (cause,), (sigma,) = gain.causes, gain.sigma_of_causes
    loud = replace(
        gain, causes=(replace(cause, amounts=10 * sigma),), noise=tuple([d / 8 for d in n] for n in gain.noise)
    )
    assert gain.excess.ratio.max() < 1.25 < 6 < loud.excess.ratio.max()
    assert (loud.untold, loud.untold_beside_what_is_left) == ((), (0,))
    (cause,) = viscous.causes
    named = (NamedCause(cause.effect, cause.where, (), 1.0, viscous.fit.loss),)
    monkeypatch.setattr(cause_search, "with_all_causes", lambda fitter, *_: (fitter, viscous))
    monkeypatch.setattr(cause_search, "with_look_alikes", lambda _, last: (named, last))
    assert search_causes(h, ensembles).named == ()
