"""The columns of a comparison: of the base model, nuisances, causes and effects, whitened and multiplied by blocks of time."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from diagnosis.cause import Cause
from diagnosis.comparison import FOLD_BLOCK_S, HELD_SIGMA, Comparison, EffectColumns
from diagnosis.effect import Effect, Shape
from diagnosis.linearisation import Linearisation
from diagnosis.nuisances import MAX_TOLERANCES, Nuisances
from identification.fitting import segment_starts
from identification.unknowns import DELAY, DELAY_SIGMA_S
from identification.whitening import Whitener

Array = NDArray[np.float64]


def compare(
    at: Linearisation,
    causes: Sequence[Cause],
    effects: Sequence[tuple[Effect, Shape]],
    nuisances: Nuisances,
    whiten: Whitener,
    noise: Sequence[Sequence[Array]] = (),
    clock_relaxed: bool | None = None,
) -> Comparison:
    """Causes that the linearisation's hypothesis holds, and effects beside them, each in the shape given.

    noise: draws of each recording. clock_relaxed: whether the clock is in doubt; unless said, it is where a cause is named that
    is not the clock itself.
    """
    matrices, widths = column_matrices(at, causes, effects, nuisances)
    nuisance_count = nuisances.count + 2 * len(at.recordings)
    first = len(at.unknowns.size) + nuisance_count
    slots = [np.arange(a, b) for a, b in pairwise(first + np.cumsum([0, *widths]))]
    block_products, noise_products, row_count = _products(at, matrices, whiten, noise)
    prior_sigma, relaxed_sigma, prior_mean = _priors(at, nuisances, first, first + sum(widths))
    lower_bounds, upper_bounds = _bounds(at, nuisances, prior_mean)
    for cause, slot in zip(causes, slots, strict=False):
        of_amounts, of_shape = np.split(slot, [len(cause.amounts)])
        lower_bounds[of_amounts] = cause.least_steps(at.hypothesis.arm)
        prior_mean[of_shape], prior_sigma[of_shape] = cause.known_shape(at.hypothesis.arm)
        at_limit = of_shape[cause.at_limit(at.hypothesis.arm)]
        prior_sigma[at_limit], prior_mean[at_limit] = HELD_SIGMA, 0.0
        relaxed_sigma[of_shape] = prior_sigma[of_shape]
    if clock_relaxed is None:
        clock_relaxed = bool(causes) and not any(cause.effect.is_clock for cause in causes)
    return Comparison(
        linearisation=at,
        matrices=tuple(matrices),
        base_count=len(at.unknowns.size),
        nuisance_count=nuisance_count,
        cause_columns=np.concatenate([np.zeros(0, dtype=int), *slots[: len(causes)]]).astype(int),
        groups=tuple(
            EffectColumns(effect, shape, slot)
            for (effect, shape), slot in zip(effects, slots[len(causes) :], strict=True)
        ),
        block_products=block_products,
        noise_products=noise_products,
        prior_sigma=prior_sigma,
        relaxed_sigma=relaxed_sigma,
        prior_mean=prior_mean,
        lower_bounds=lower_bounds,
        upper_bounds=upper_bounds,
        nuisances=nuisances,
        clock_relaxed=clock_relaxed,
        row_count=row_count,
    )


def column_matrices(
    at: Linearisation, causes: Sequence[Cause], effects: Sequence[tuple[Effect, Shape]], nuisances: Nuisances
) -> tuple[list[Array], list[int]]:
    """Columns and residual of each recording, (C, S, K + 1), and the number of columns of each cause and effect."""
    arm = at.recordings[0].signals.arm
    matrices: list[Array] = []
    widths: list[int] = []
    for r, recording in enumerate(at.recordings):
        clocks = np.zeros((*recording.rows.residual.shape, 2 * len(at.recordings)))
        clocks[..., 2 * r : 2 * r + 2] = nuisances.clock_columns[r]
        further = [cause.columns(recording) for cause in causes]
        further += [effect.columns(recording, shape) * effect.sizes(arm) for effect, shape in effects]
        widths = [part.shape[2] for part in further]
        base = recording.rows.jacobian * at.unknowns.size
        residual = recording.rows.residual[..., None]
        matrices.append(np.concatenate([base, nuisances.arm_columns[r], clocks, *further, residual], axis=2))
    return matrices, widths


def _products(
    at: Linearisation, matrices: Sequence[Array], whiten: Whitener, noise: Sequence[Sequence[Array]]
) -> tuple[Array, Array, int]:
    """By blocks: products of whitened columns with each other and with draws of noise; the number of rows that count."""
    block_products, noise_products, row_count = [], [], 0
    for r, (matrix, recording) in enumerate(zip(matrices, at.recordings, strict=True)):
        s, variance = recording.signals, recording.input_variance
        starts, width = segment_starts(s), matrix.shape[2]
        white = whiten(matrix, starts, variance)
        white_noise = whiten(np.stack(noise[r], axis=-1), starts, variance) if noise else white[..., :0]
        length = max(1, round(FOLD_BLOCK_S / (s.step * s.low_pass.factor)))
        for begin in range(0, white.shape[1], length):
            rows = white[:, begin : begin + length].reshape(-1, width)
            block_products.append(rows.T @ rows)
            noise_products.append(rows[:, :-1].T @ white_noise[:, begin : begin + length].reshape(len(rows), -1))
        row_count += int(np.count_nonzero(white[..., -1]))
    return np.array(block_products), np.array(noise_products), row_count


def _priors(at: Linearisation, nuisances: Nuisances, first: int, count: int) -> tuple[Array, Array, Array]:
    """Sigma, the same with clocks in doubt, and mean of what is known beforehand, (count,); first: behind the nuisances."""
    size = at.unknowns.size
    sigma, mean = np.full(count, np.inf), np.zeros(count)
    sigma[len(size) : first] = 1.0
    mean[len(size) : len(size) + nuisances.count] = -nuisances.departures
    for i, entry in enumerate(at.unknowns.entries):
        known_to = DELAY_SIGMA_S if entry.term is DELAY else entry.term.sigma
        if np.isfinite(known_to):
            sigma[i], mean[i] = known_to / entry.term.size, -at.p[i] / entry.term.size
    relaxed = sigma.copy()
    recordings = len(at.recordings)
    for r in range(recordings):
        clock = first - 2 * recordings + 2 * r
        relaxed[clock] = nuisances.clock_relaxation[r]
        mean[clock] = -at.frame_lags[r] / nuisances.clock_sigma[r]
    return sigma, relaxed, mean


def _bounds(at: Linearisation, nuisances: Nuisances, known: Array) -> tuple[Array, Array]:
    """Least and greatest values of the numbers, (K,) each; known: what they are known to be beforehand.

    What is nothing at zero may come out a little below by chance, but no further. An arm far beyond what its drawing is good for,
    or a motor whose friction follows another curve, is not the one described: causes are asked for that."""
    lowest = [e.term.low - (e.term.size if e.term.linear and e.term.low == 0 else 0.0) for e in at.unknowns.entries]
    low, high = np.full(len(known), -np.inf), np.full(len(known), np.inf)
    low[: len(lowest)] = np.minimum(np.array(lowest) - at.p, 0.0) / at.unknowns.size
    of_arm = slice(len(lowest), len(lowest) + nuisances.count)
    low[of_arm], high[of_arm] = known[of_arm] - MAX_TOLERANCES, known[of_arm] + MAX_TOLERANCES
    return low, high
