"""The clock's sigma has three parts: noise, spread of models, and bias. Fits are made up so that each part is large once."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synchronisation.clocks import fine_alignment
from synchronisation.clocks.fine_alignment import FineAlignment, align_finely
from synchronisation.clocks.gauss_newton_step import SKEW_SCALE

FRAMES: Any = SimpleNamespace(time=np.linspace(0, 40, 1200), with_slopes_beside_noise=lambda *_: None)
BIAS_S, DELAY_BIAS_S = 8e-6, 1e-5
"""by filters, which no fit shows"""


def fit(offset: float, skew: float, delay: float, sigma: float, misfit: float = 1.0, held: bool = False) -> Any:
    """A solution with `sigma` s of noise in offset and delay, and sigma/20 s in the skew."""
    variance = sigma**2 * np.array([1.0, 1 / (20 * SKEW_SCALE) ** 2, 1.0])
    return SimpleNamespace(
        unknowns=SimpleNamespace(
            offset=offset,
            skew=skew,
            delay=delay,
            cable_error=np.full(4, misfit),
            fv=np.zeros(4),
            noise_scale=1.0,
            torque_misfit=1.0,
            cable_parameters=np.zeros((4, len(fine_alignment.REPORTED.law.names))),
        ),
        equations=SimpleNamespace(covariance=lambda count: np.diag(variance)[:count, :count]),
        residual=np.zeros((1200, 4)),
        rows=SimpleNamespace(at_rest=np.zeros((1200, 4), dtype=bool)),
        cables=SimpleNamespace(tau=0.0),
        held=SimpleNamespace(motors=np.array([False, held, False, False])),
    )


def aligned(
    monkeypatch: pytest.MonkeyPatch,
    sigma: float,
    others: list[tuple[float, float, float]],
    from_cables: float = 1.0,
    fv: float = 0.0,
) -> FineAlignment:
    """With alternatives so far off the reported fit, in s, ratio and s; from_cables: s, the offset by these alone."""
    reported = fit(1.0, 1e-5, 2e-3, sigma)
    reported.unknowns.fv = np.array([0.0, fv, 0.0, 0.0])
    alternatives = [fit(1.0 + o, 1e-5 + s, 2e-3 + d, sigma) for o, s, d in others]
    nothing: Any = None
    monkeypatch.setattr(fine_alignment, "CableEquation", lambda *_: nothing)
    monkeypatch.setattr(fine_alignment, "initial_unknowns", lambda *_: nothing)
    monkeypatch.setattr(fine_alignment, "solve_clock", lambda *_: fit(from_cables, 0.0, 0.0, sigma))
    explained = fine_alignment._Explained(reported, nothing, fine_alignment.REPORTED)
    monkeypatch.setattr(fine_alignment, "_sound_or_lossy", lambda *_: explained)
    monkeypatch.setattr(fine_alignment, "_with_or_without_memory", lambda *_: explained)
    monkeypatch.setattr(fine_alignment, "_alternatives", lambda *_: alternatives)
    return align_finely(nothing, nothing, FRAMES, 1.0, np.zeros(4))


def test_with_neither_noise_nor_spread_the_bias_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which may differ from one end to the other: over half of 40 s it is a skew."""
    for others in ([], [(0.0, 0.0, 0.0)] * 3):
        found = aligned(monkeypatch, 1e-12, others)
        assert found.offset_sigma == pytest.approx(BIAS_S, rel=1e-6)
        assert found.skew_sigma == pytest.approx(BIAS_S / 20, rel=1e-6)
        assert found.delay_sigma == pytest.approx(DELAY_BIAS_S, rel=1e-6)


def test_noise_counts_as_the_fit_says(monkeypatch: pytest.MonkeyPatch) -> None:
    found = aligned(monkeypatch, 1e-3, [])
    assert found.offset_sigma == pytest.approx(np.hypot(1e-3, BIAS_S), rel=1e-9)
    assert found.skew_sigma == pytest.approx(np.hypot(1e-3, BIAS_S) / 20, rel=1e-9)
    assert found.delay_sigma == pytest.approx(np.hypot(1e-3, DELAY_BIAS_S), rel=1e-9)


def test_models_that_explain_as_much_and_disagree_widen_the_sigma_by_their_spread(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One of two is 2 ms off: half of that squared twice, over one, is 2 ms^2, so sqrt(2) ms; of three at -d, 0, d it is d."""
    found = aligned(monkeypatch, 1e-12, [(2e-3, 0.0, 0.0)])
    assert found.offset_sigma == pytest.approx(np.hypot(np.sqrt(2) * 1e-3, BIAS_S), rel=1e-9)
    assert found.skew_sigma == pytest.approx(BIAS_S / 20, rel=1e-6)
    found = aligned(monkeypatch, 1e-12, [(0.0, 3e-5, -4e-3), (0.0, -3e-5, 4e-3)])
    assert found.offset_sigma == pytest.approx(BIAS_S, rel=1e-6)
    assert found.skew_sigma == pytest.approx(np.hypot(3e-5, BIAS_S / 20), rel=1e-9)
    assert found.delay_sigma == pytest.approx(np.hypot(4e-3, DELAY_BIAS_S), rel=1e-9)
    assert found.fit.unknowns.offset == 1.0


@pytest.mark.parametrize(("misfit", "counts"), [(1.14, True), (1.16, False)])
@pytest.mark.parametrize(("memory", "others"), [(0.0, 5), (1.0, 6)])
def test_a_model_that_explains_less_has_no_say(
    misfit: float, counts: bool, memory: float, others: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where cables remember, one more model has operators of other widths."""
    explained = with_memory(fit(1.0, 0.0, 0.0, 1e-6), memory)
    monkeypatch.setattr(fine_alignment, "_refitted", lambda *_: fit(1.1, 0.0, 0.0, 1e-6, misfit))
    found = fine_alignment._alternatives(SimpleNamespace(signals=None), explained)  # type: ignore[arg-type]
    assert len(found) == (others if counts else 0)


@pytest.mark.parametrize("held", [False, True])
def test_where_friction_holds_motors_what_was_not_taken_has_a_say(held: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    explained = with_memory(fit(1.0, 0.0, 0.0, 1e-6, held=held), 0.0)
    explained = replace(explained, tried=(fit(1.2, 0.0, 0.0, 1e-6, 1.1), fit(1.3, 0.0, 0.0, 1e-6, 1.2)))
    monkeypatch.setattr(fine_alignment, "_refitted", lambda *_: fit(1.1, 0.0, 0.0, 1e-6, 1.2))
    found = fine_alignment._alternatives(SimpleNamespace(signals=None), explained)  # type: ignore[arg-type]
    assert [other.unknowns.offset for other in found] == [1.2] * held


def with_memory(solution: Any, memory: float) -> Any:
    reported = fine_alignment.REPORTED
    assumptions = replace(reported, law=replace(reported.law, memory=memory))
    rows: Any = SimpleNamespace(with_joint_width=lambda _: None)
    return fine_alignment._Explained(solution, rows, assumptions)


@pytest.mark.parametrize(("left_m", "with_memory_m", "remembers"), [(1e-5, 0.7e-5, 1.0), (1e-5, 0.9e-5, 0.0)])
def test_cables_remember_where_that_leaves_much_less(
    left_m: float, with_memory_m: float, remembers: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fifth less at the least."""
    usual = with_memory(fit(1.0, 0.0, 0.0, 1e-6, left_m), 0.0)
    trial = fit(1.0, 0.0, 0.0, 1e-6, with_memory_m)
    monkeypatch.setattr(fine_alignment, "_refitted", lambda *_: trial)
    monkeypatch.setattr(fine_alignment, "_sound_or_lossy", lambda *of: with_memory(trial, of[3].law.memory))
    monkeypatch.setattr(
        fine_alignment, "replace", lambda one, **of: one if type(one) is SimpleNamespace else replace(one, **of)
    )
    nothing: Any = None
    found = fine_alignment._with_or_without_memory(nothing, nothing, usual)
    assert found.assumptions.law.memory == remembers


def test_misfit_is_in_cables_times_angles_times_joints() -> None:
    """A clock with a false loss left less of the cables, and of the angles twice as much as the true one."""
    one = SimpleNamespace(cable_error=np.array([1.0, 4.0]), noise_scale=3.0, torque_misfit=2.0)
    assert fine_alignment.clock_misfit(one) == pytest.approx(12.0)  # type: ignore[arg-type]
    one.noise_scale = 0.1  # angles are no better than their sigma because cables err by much
    assert fine_alignment.clock_misfit(one) == pytest.approx(4.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(("fv", "counts"), [(-0.1, 1.0), (-0.01, 0.0)])
def test_motors_that_would_drive_widen_the_sigma_by_what_they_moved(
    fv: float, counts: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = aligned(monkeypatch, 1e-12, [], from_cables=1.003, fv=fv)
    assert found.offset_sigma == pytest.approx(np.hypot(3e-3 * counts, BIAS_S), rel=1e-6)
    assert found.skew_sigma == pytest.approx(BIAS_S / 20, rel=1e-6)
