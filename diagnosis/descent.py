"""Steps by which causes, the base model's numbers and doubtful clocks come to a least loss together, by Levenberg and Marquardt."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause, with_causes
from diagnosis.compare import compare
from diagnosis.comparison import ColumnFit, Comparison, Index
from diagnosis.fit_stage import FAR
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation, base_unknowns, corrected_signals, linearise, with_laws_of
from diagnosis.nuisances import nuisances_at
from identification.dataset.dataset import DataSet
from identification.whitening import Whitener

Array = NDArray[np.float64]

_MAX_ROUNDS, _MAX_STEPS, _FIRST_STEPS = 3, 24, 6
"""of steps, steps of a round, and steps of one that only brings the laws near enough to tell speeds by"""
_MIN_CLOCK_STEP_S = 1e-4
"""s: up to which frames need not be read anew, for what they show changes in proportion"""
_MIN_PROMISE, _MIN_PROMISE_SHARE = 2.0, 1e-2
"""of the loss, and of what of it is beyond noise: a step that promises less is not taken, for the fit ends with a straight one"""
_SHORT_GAIN = 0.5
"""of what a straight step promised: where it took less, shapes may have gone ahead of all else"""
_SETTLING_STEPS = 4
"""for given shapes: most numbers are all but linear"""
_MAX_LAST_CHANGE = 0.5
"""of a number that acts by its ratio: change that a straight step tells of"""
_MIN_LOSS_GAIN, MIN_LOSS_GAIN_FAR = 1e-3, 1e-2
"""of the loss: a step that took less away was the last; and where far more than noise is left"""
_NEARER_SHARE = 0.3
"""of what a straight step promised: what is promised after a good one"""
_PATIENCE = 6
"""steps of a round in which the least loss may stay as it is, but for a little of what is promised: more go round in circles"""
_KEPT_PROMISE = 0.05
"""of what a straight step promised: where steps take less again and again, the loss is not what straight steps see"""
_LOST = 1.5
"""times the least loss of a round: one that ends there has lost its way"""
_FIRST_DAMPING, _MAX_DAMPING = 1e-3, 10.0
_DAMPING_DECREASE, _DAMPING_INCREASE = 3.0, 8.0


@dataclass(frozen=True)
class Descent:
    """From where causes stand to where the loss of recordings is least."""

    h: Hypothesis
    """to which causes are added"""
    data: Sequence[DataSet]
    whiten: Whitener

    def refined(
        self,
        start: Linearisation,
        causes: tuple[Cause, ...],
        rough: bool = False,
        is_hopeless: Callable[[Comparison], bool] = lambda current: False,
    ) -> tuple[Comparison, tuple[Cause, ...]]:
        """The least loss from a linearisation on, and the causes there; rough: one short round.

        What nuisances do changes little on the way: it is told anew where a round of steps has ended. is_hopeless: asked there
        whether what is left makes more rounds needless."""
        causes = tuple(cause.begun() for cause in causes)
        at, damping = self._linearised(start, causes, start.p, start.frame_lags), 0.0
        current = compare(at, causes, (), nuisances_at(at), self.whiten)
        for _ in range(1 if rough else _MAX_ROUNDS):
            before = current.profiled_loss
            if with_whole_causes(current, causes).promised < _least_promise(current):
                break
            stepped, causes, damping = self._round(current, causes, damping, _FIRST_STEPS if rough else _MAX_STEPS)
            if rough or is_hopeless(stepped):
                return stepped, causes
            at = stepped.linearisation
            current = compare(at, causes, (), nuisances_at(at), self.whiten)
            if abs(current.profiled_loss / before - 1) < _least_loss_gain(current):
                break
        return current, causes

    def step(
        self, current: Comparison, damping: float, causes: tuple[Cause, ...]
    ) -> tuple[Comparison, tuple[Cause, ...]]:
        """Where a damped step leads to, with the same nuisances."""
        fit = with_whole_causes(current, causes).fit(damping=damping)
        nuisances_end = current.base_count + current.nuisance_count
        step = np.append(fit.numbers[: current.base_count], fit.numbers[nuisances_end:])
        at = current.linearisation
        p, stepped = _stepped(at, causes, step)
        lags = at.frame_lags
        if current.clock_relaxed:
            shifts = current.clock_shifts(fit)
            lags = lags + np.where(np.abs(shifts) > _MIN_CLOCK_STEP_S, shifts, 0.0)
        return compare(self._linearised(at, stepped, p, lags), stepped, (), current.nuisances, self.whiten), stepped

    def _round(
        self, current: Comparison, causes: tuple[Cause, ...], last_damping: float, max_steps: int
    ) -> tuple[Comparison, tuple[Cause, ...], float]:
        """One round of steps, with nuisances that act as where it begins, and the damping with which steps last gained.

        last_damping: that of the round before, with which damping begins where a straight step gains nothing."""
        current = with_whole_causes(current, causes)
        damping, was_small, best, idle = 0.0, False, (current, causes), 0
        for _ in range(max_steps):
            if current.promised < _least_promise(current) or idle == _PATIENCE:
                break
            idle += 1
            candidate, stepped = self.step(current, damping, causes)
            gain = _gain(candidate, current)
            is_short = gain < _SHORT_GAIN * current.promised / current.profiled_loss
            if is_short and damping == 0 and any(cause.shape for cause in stepped):
                settled, so_far = self._settled(candidate, stepped, current.profiled_loss)
                if _gain(settled, current) > gain:
                    candidate, stepped, gain = settled, so_far, _gain(settled, current)
            candidate = with_whole_causes(candidate, stepped)
            if gain > 0 or _is_nearer(candidate, current):
                worth = max(_MIN_LOSS_GAIN * best[0].profiled_loss, _KEPT_PROMISE * current.promised)
                current, causes = candidate, stepped
                if current.profiled_loss < best[0].profiled_loss - worth:
                    idle = 0
                best = min(best, (current, causes), key=lambda at: at[0].profiled_loss)
                last_damping = damping
                damping = damping / _DAMPING_DECREASE if damping > _FIRST_DAMPING else 0.0
                is_small = gain < _least_loss_gain(current)
                if is_small and (damping == 0 or was_small):
                    break
                was_small = is_small
            elif current.promised < _least_loss_gain(current) * current.profiled_loss:
                break
            else:
                damping = _DAMPING_INCREASE * damping if damping else max(_FIRST_DAMPING, last_damping)
                if damping > _MAX_DAMPING:
                    break
        # steps along a bent valley may leave it for good, or go to and fro across it
        in_circles = idle == _PATIENCE and current.profiled_loss > FAR * current.row_count
        if in_circles or current.profiled_loss > _LOST * best[0].profiled_loss:
            current, causes = best
        return current, causes, last_damping

    def _settled(
        self, stepped: Comparison, causes: tuple[Cause, ...], to_beat: float
    ) -> tuple[Comparison, tuple[Cause, ...]]:
        """Where a step led to, all numbers at their best for the shapes there, if that can leave less than `to_beat`.

        Of a shape and the amounts that go with it the loss is a narrow, bent valley: along its tangent a step leaves it."""
        current = stepped
        for _ in range(_SETTLING_STEPS):
            first, columns = current.base_count + current.nuisance_count, []
            for cause in causes:
                count = len(cause.sizes(current.linearisation.hypothesis.arm))
                columns += range(first + len(cause.amounts), first + count)
                first += count
            held = current.with_held(np.array(columns, dtype=np.intp))
            if held.profiled_loss - held.promised > to_beat or held.promised < _least_promise(held):
                break
            current, causes = self.step(held, 0.0, causes)
        return current, causes

    def _linearised(
        self, nearby: Linearisation, causes: tuple[Cause, ...], p: Array, frame_lags: Array
    ) -> Linearisation:
        """A linearisation with causes; where only laws differ from one nearby, its recordings as they were read."""
        h, old = with_causes(self.h, causes), nearby.hypothesis
        p = nearby.unknowns.carried(p, base_unknowns(h, len(self.data)))
        same_speeds = all(r.signals.speeds is d.speeds for r, d in zip(nearby.recordings, self.data, strict=True))
        same_lags = np.array_equal(frame_lags, nearby.frame_lags)
        if not (same_speeds and same_lags and h.reading == old.reading):
            return linearise(h, corrected_signals(h, self.data, frame_lags), p, frame_lags)
        return with_laws_of(nearby, h, p)


def with_whole_causes(current: Comparison, causes: Sequence[Cause]) -> Comparison:
    """A comparison in which amounts of causes that are there in full or not at all stay as they are."""
    first, columns = current.base_count + current.nuisance_count, []
    for cause in causes:
        if cause.effect.in_full:
            columns += range(first, first + len(cause.amounts))
        first += len(cause.sizes(current.linearisation.hypothesis.arm))
    return current.with_held(np.array(columns, dtype=np.intp)) if columns else current


def last_fit(current: Comparison, held: Sequence[int] | Index = ()) -> ColumnFit:
    """The fit with which steps end, a straight one: but columns that are held (k,), and numbers that it would take far, stay.

    A number that acts by its ratio, as the speed over which friction turns over, goes anywhere by a straight step where nothing
    tells it, and may do much there to other recordings.
    """
    fit, u = current.fit(), current.linearisation.unknowns
    step, value = np.abs(u.size * fit.numbers[: current.base_count]), current.linearisation.p
    acts_by_ratio = np.array([entry.term.low > 0 for entry in u.entries])
    far = np.flatnonzero(acts_by_ratio & (step > _MAX_LAST_CHANGE * value))
    return current.with_held(np.append(np.asarray(held, dtype=np.intp), far)).fit()


def _gain(candidate: Comparison, current: Comparison) -> float:
    """Share of the loss that a step took away.

    The base model's numbers are all but linear: they follow what the causes' are, in the next step."""
    return 1 - min(
        candidate.profiled_loss / current.profiled_loss,
        candidate.loss_with_fixed_causes / current.loss_with_fixed_causes,
    )


def _is_nearer(candidate: Comparison, current: Comparison) -> bool:
    """Whether a step that did not lessen the loss led to where its columns promise little more.

    Near noise the loss is no judge: a heavier arm makes more of the angles' noise. Columns are of smooth motions, free of it."""
    is_near = candidate.profiled_loss < FAR * candidate.row_count
    return is_near and candidate.promised < _NEARER_SHARE * current.promised


def _least_loss_gain(current: Comparison) -> float:
    """Share of the loss below which a step was the last."""
    return MIN_LOSS_GAIN_FAR if current.profiled_loss > FAR * current.row_count else _MIN_LOSS_GAIN


def _least_promise(current: Comparison) -> float:
    """Below which no step is taken."""
    return max(_MIN_PROMISE, _MIN_PROMISE_SHARE * (current.profiled_loss - current.row_count))


def _stepped(at: Linearisation, causes: tuple[Cause, ...], step: Array) -> tuple[Array, tuple[Cause, ...]]:
    """The base model's numbers and the causes, moved by a step in their sizes."""
    u, arm = at.unknowns, at.hypothesis.arm
    base_step, rest = np.split(step, [len(u.size)])
    p, stepped = np.clip(at.p + u.size * base_step, u.low, u.high), []
    for cause in causes:
        cause_step, rest = np.split(rest, [len(cause.sizes(arm))])
        stepped.append(cause.stepped(cause_step, arm))
    return p, tuple(stepped)
