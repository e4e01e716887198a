"""What noise alone leaves of the residuals: recordings of the same motion with angles drawn anew, through the same chain.

The state as estimated stands for the truth. What smoothing takes away from it, and what the camera's noise adds, is in the
draws; what the base model cannot say is not. That is the floor which a true model would reach.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from diagnosis.linearisation import Linearisation, read_all
from identification.dataset.dataset import DataSet
from identification.dataset.frames import FrameAngles, between_frames
from identification.dataset.series import Series, numbered
from identification.fitting import stretch_starts
from identification.residuals import forces_at, left
from identification.whitening import Whitener, fit_whitener
from state_estimation.state import VisionState, by_vision

Array = NDArray[np.float64]

DRAWS = 4
_ELSE = (0.03, 0.10)
"""part of a channel's noise, of the motors' and of the arm's equations, that is laid under it as white: rounding of forces and
the shape of friction's reversal reach frequencies where cameras leave next to nothing"""


@dataclass(frozen=True)
class NoiseEnsemble:
    """A recording by vision alone, and the same with its angles drawn anew."""

    data: DataSet
    drawn: tuple[DataSet, ...]
    smooth: DataSet
    """where every frame shows the state itself"""


def read(data: DataSet, seen: FrameAngles, seed: int, draws: int = DRAWS) -> NoiseEnsemble:
    """seen: the frames on the log's clock. Cables have no part in the state: what they do is what is in question."""
    found = by_vision(seen, data.state.time)
    alone = _with(data, seen, found)
    state = alone.state
    truth = make_interp_spline(state.time, state.matrix("alpha"), k=5)
    inside = (seen.time >= state.time[0]) & (seen.time <= state.time[-1])
    shown = seen.alpha.copy()
    shown[inside] = np.where(np.isnan(seen.alpha[inside]), np.nan, truth(seen.time[inside]))
    rng = np.random.default_rng(seed)
    drawn = []
    for _ in range(draws):
        other = replace(seen, alpha=shown + seen.sigma * rng.normal(size=shown.shape))
        drawn.append(_with(data, other, by_vision(other, state.time, found.priors)))
    columns = {**state.columns, **numbered("vision", state.matrix("alpha"))}
    columns |= numbered("vision", state.matrix("alpha", "_d"), "_d")
    return NoiseEnsemble(alone, tuple(drawn), replace(alone, state=Series(state.time, columns)))


def _with(data: DataSet, seen: FrameAngles, found: VisionState) -> DataSet:
    """The data set with a state by vision alone."""
    s = data.state
    columns = dict(s.columns)
    for suffix, values in (("", found.alpha), ("_d", found.alpha_d), ("_dd", found.alpha_dd)):
        columns |= numbered("alpha", values, suffix)
    own, own_d = between_frames(seen.time, seen.alpha, s.time)
    columns |= numbered("vision", own) | numbered("vision", own_d, "_d")
    columns |= numbered("bridged", found.bridged.astype(float))
    return replace(data, state=Series(s.time, columns))


def noise(at: Linearisation, recordings: Sequence[NoiseEnsemble]) -> list[list[Array]]:
    """Residuals at a point where nothing is wrong, (C, S), of each draw of each recording: noise, and what is unsure of motors."""
    rng = np.random.default_rng(0)
    out = []
    for draws, place in zip(seen_noise(at, recordings), at.places, strict=True):
        out.append([d + np.sqrt(place.unsure) * rng.normal(size=d.shape) for d in draws])
    return out


def seen_noise(at: Linearisation, recordings: Sequence[NoiseEnsemble]) -> list[list[Array]]:
    """Of these, what noise of the angles makes."""
    out = []
    for r, one in enumerate(recordings):
        every = read_all(at.hypothesis, (one.smooth, *one.drawn), np.full(1 + len(one.drawn), at.late[r]))
        tension = at.places[r].tension
        true, *drawn = (left(s, forces_at(s, at.unknowns, at.p, r, tension)) for s in every)
        out.append([d - true for d in drawn])
    return out


def quiet(drawn: list[list[Array]], at: Linearisation, whiten: Whitener) -> float:
    """Loss that noise alone makes, as one draw of each recording."""
    return sum(
        float(np.mean([np.sum(whiten(d, stretch_starts(place.signals), place.unsure) ** 2) for d in draws]))
        for draws, place in zip(drawn, at.places, strict=True)
    )


def whitener(drawn: list[list[Array]], starts: list[NDArray[np.bool_]], motors: int) -> Whitener:
    """Each channel's noise told from what came before, from all draws."""
    rng = np.random.default_rng(0)
    flat, begins = [], []
    for draws, begin in zip(drawn, starts, strict=True):
        for residual in draws:
            part = np.where(np.arange(len(residual)) < motors, *_ELSE)[:, None]
            flat.append(residual + part * residual.std(axis=1, keepdims=True) * rng.normal(size=residual.shape))
            begins.append(begin)
    return fit_whitener(flat, begins)
