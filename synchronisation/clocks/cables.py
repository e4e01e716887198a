"""The cables' equation of the clock: (rd/R) theta = w(alpha) + x, with x explained by the force.

x = c + g(t) + creep, t = n - h dry(theta') - w turning(theta') - fv theta' - ca x', with g a polynomial of each cable, w by how
much sooner than usual friction turns over, n late by a delay and off by errors of motors' inertia, and w(alpha) off by errors of
the arm's dimensions. Offset and skew move the log's signals against the camera's alpha. There is a row for every cable and frame,
weighted by what vision's noise and the model's own error leave uncertain; with more cables than joints the difference of both is
seen.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from mechanism.arm import Arm
from mechanism.cable_lengths import Z, lengths
from synchronisation.clocks.signals import LogSignals, cubic, lagged
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

NEWTON = 50.0
"""N: brings tensions to the size of one"""
SKEW = 1e-4
"""ratio: brings the skew to the size of one"""
LEAST_ERROR = 2e-6
"""m: a model of a cable is never believed better than this"""
FIRST_ERROR = 3e-5
"""m: the same before anything is fitted"""
LEAST_SCALE = 0.1
"""angles are never believed ten times better than they say"""
WIDE = {"c": 0.1, "g": 0.05, "h": 2.0, "w": 1.0, "i": 0.01, "ca": 10.0, "creep": 0.01, "drum": 0.1}
"""in m, and in NEWTON where it is a force; of a drum and of a motor's inertia its share"""
_PARTS = 6
"""of a tension: force, friction, its turning over, speed, the command's rate, and inertia"""
DIMENSIONS = ("L", "b", "r")
"""of each mechanism, that a description may have slightly wrong"""
LARGER = 1e-3
"""of a dimension, for its slope"""
LONGEST_LAG = 0.05
"""s: what a damped cable may lag behind its force"""


@dataclass(frozen=True)
class CableTerms:
    """What an elongation may consist of: powers of the tension, creep with time constants in s, damping, friction that turns
    over sooner or later; motors' inertia and drums that are off."""

    powers: int = 3
    creep: tuple[float, ...] = (3.0,)
    damping: bool = True
    width: bool = True
    inertia: bool = True
    drum: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters that each cable has for itself."""
        powers = tuple(f"g{p + 1}" for p in range(self.powers))
        creep = tuple(f"creep{k}" for k in range(len(self.creep)))
        more = [
            name
            for name, held in (("w", self.width), ("i", self.inertia), ("ca", self.damping), ("drum", self.drum))
            if held
        ]
        return ("c", *powers, "h", *more, *creep)

    @property
    def wide(self) -> Array:
        """What each of these can be at most, roughly: a weak prior that keeps unexcited laws at nothing, (K,)."""
        return np.array([WIDE.get(name.rstrip("0123456789"), 1.0) for name in self.names])


@dataclass(frozen=True)
class Frames:
    """Frames with all angles: camera time (F,), s; alpha and its sigma (F, N), rad; what the cables make of them."""

    time: Array
    alpha: Array
    sigma: Array
    winding: Array
    """-(l(alpha) - l(0)), (F, M), m"""
    Z: Array
    """(F, N, M), m/rad"""
    solver: Array
    """(F, N, M): turns of the joints that explain travels best, rad/m"""
    by_model: Array
    """(F, N): their variance for travels of unit variance, rad^2/m^2"""
    by_dimension: Array
    """(F, M, P): what the winding gains where the arm's dimensions are larger than described, m"""
    middle: float
    """camera time at which the offset holds, s"""

    def with_dimensions(self, off: Array) -> "Frames":
        """The same frames of an arm whose dimensions are off (P,) larger than described."""
        return replace(self, winding=self.winding + self.by_dimension @ off)


def frames_of(arm: Arm, time: Array, alpha: Array, sigma: Array, middle: float) -> Frames:
    """Frames whose angles are all known."""
    winding = wound(arm, alpha)
    by_dimension = np.stack([wound(other, alpha) - winding for other in larger(arm)], axis=-1) / LARGER
    jacobian = Z(arm, alpha)
    square = np.einsum("fij,fkj->fik", jacobian, jacobian)
    # more joints than cables leave a turn that moves none: the ridge keeps it at nothing
    inverse = np.linalg.inv(square + 1e-9 * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(arm.N))
    return Frames(
        time,
        alpha,
        sigma,
        winding,
        jacobian,
        inverse @ jacobian,
        np.diagonal(inverse, axis1=1, axis2=2),
        by_dimension,
        middle,
    )


def wound(arm: Arm, alpha: Array) -> Array:
    """-(l(alpha) - l(0)), (..., M), m, at angles (..., N), rad."""
    return lengths(arm, np.zeros(arm.N)) - lengths(arm, alpha)


def larger(arm: Arm) -> list[Arm]:
    """The arm with each of its L, b and r LARGER of it longer, one at a time."""
    one = np.eye(arm.N)
    return [
        replace(arm, **{name: getattr(arm, name) * (1 + LARGER * one[i])}) for name in DIMENSIONS for i in range(arm.N)
    ]


@dataclass(frozen=True)
class ClockRows:
    """Residuals (F, M), m; slopes by offset, delay and fv (F, M), by dimensions (F, M, P), by each cable's own (F, M, K)."""

    residual: Array
    by_offset: Array
    by_delay: Array
    by_fv: Array
    by_dimension: Array
    by_own: Array


class Cables:
    """The curves of a log that a law needs, and rows for given parameters."""

    def __init__(self, signals: LogSignals, law: CableTerms, tau: Array | float = 0.0) -> None:
        s, step = signals, float(signals.time[1] - signals.time[0])
        base = [
            s.force(s.time),
            s.rubbing(s.time),
            s.turning(s.time),
            s.speed(s.time),
            s.command(s.time, 1),
            s.inertial(s.time),
        ]
        m = base[0].shape[1]
        self.law = law
        self.tau = np.broadcast_to(np.asarray(tau, dtype=float), (m,))
        self._usual = base[0].mean(axis=0)
        base = [lagged(values, step, self.tau) for values in base]
        late = [lagged(values, step, np.full(m, long)) for long in law.creep for values in base]
        self._curves = cubic(s.time, np.stack([s.travel(s.time), *base, *late], axis=-1))
        self._time = s.time
        self._span = (s.time[0], s.time[-1])

    def lag(self, own: Array) -> Array:
        """Time constants ca g' of the cables at their mean tension, (M,), s."""
        p = dict(zip(self.law.names, own.T, strict=True))
        if not self.law.damping:
            return np.zeros(len(own))
        powers = [p[f"g{k + 1}"] for k in range(self.law.powers)]
        return np.clip(p["ca"] * NEWTON * _slope(powers, self._usual), 0.0, LONGEST_LAG)

    def start(self, frames: Frames, offset: float) -> Array:
        """Own parameters (M, K) from a linear fit of constant, force and friction."""
        travel, n, d, *_ = np.moveaxis(self._curves(np.clip(frames.time + offset, *self._span)), -1, 0)
        names = self.law.names
        own = np.zeros((travel.shape[1], len(names)))
        for j in range(len(own)):
            D = np.column_stack([np.ones(len(n)), n[:, j] / NEWTON, d[:, j]])
            c, g, h = np.linalg.lstsq(D, travel[:, j] - frames.winding[:, j], rcond=None)[0]
            own[j, names.index("c")], own[j, names.index("g1")] = c, g
            own[j, names.index("h")] = np.clip(-h / g, -1.0, 1.0) if abs(g) > 1e-6 else 0.0
        return own

    def rows(self, frames: Frames, state: ClockUnknowns) -> ClockRows:
        """Travel less winding less elongation at every frame."""
        at = frames.time + state.offset + state.skew * (frames.time - frames.middle)
        rows = self._rows(np.clip(at, *self._span), state)
        winding = frames.with_dimensions(state.dimensions).winding
        return replace(rows, residual=rows.residual - winding, by_dimension=-frames.by_dimension)

    def without_elongation(self, state: ClockUnknowns) -> BSpline:
        """Travel less elongation over the log's time, (..., M), m: what the winding should be."""
        return cubic(self._time, self._rows(self._time, state).residual)

    def _rows(self, at: Array, state: ClockUnknowns) -> ClockRows:
        """Travel less elongation at log times (F,), s, with its slopes."""
        travel, *parts = np.moveaxis(self._curves(at), -1, 0)
        travel_d, *rates = np.moveaxis(self._curves(at, 1), -1, 0)
        p = dict(zip(self.law.names, state.own.T, strict=True))
        none = np.zeros(len(state.own))
        h, w, ca = p["h"] * NEWTON, p.get("w", none) * NEWTON, p.get("ca", none) * NEWTON
        inertia = p.get("i", none)
        powers = [p[f"g{k + 1}"] for k in range(self.law.powers)]

        def loose(n: Array, d: Array, e: Array, v: Array, r: Array, i: Array) -> Array:
            return n - h * d - w * e - state.fv * v - state.delay * r - inertia * i

        # the curves lag by tau already; what is left of the damping is small and taken to first order
        now, rate = loose(*parts[:_PARTS]), loose(*rates[:_PARTS])
        x_d = _slope(powers, now) * rate
        t = now - ca * x_d + self.tau * rate
        u, slope = t / NEWTON, _slope(powers, t)
        _, d, e, v, r, i = parts[:_PARTS]
        columns = {"c": np.ones_like(t)} | {f"g{k}": u**k for k in range(1, self.law.powers + 1)}
        x = p["c"] + sum(g * columns[f"g{k}"] for k, g in enumerate(powers, 1))
        columns |= {"h": -slope * d * NEWTON, "w": -slope * e * NEWTON, "i": -slope * i, "ca": -slope * x_d * NEWTON}
        by_fv, by_delay = -slope * v, -slope * r
        for k in range(len(self.law.creep)):
            late = parts[_PARTS * (k + 1) : _PARTS * (k + 2)]
            share = p[f"creep{k}"] / NEWTON
            columns[f"creep{k}"] = loose(*late) / NEWTON
            x = x + p[f"creep{k}"] * columns[f"creep{k}"]
            _, d_c, e_c, v_c, r_c, i_c = late
            columns["h"] = columns["h"] - share * d_c * NEWTON
            columns["w"] = columns["w"] - share * e_c * NEWTON
            columns["i"] = columns["i"] - share * i_c
            by_fv, by_delay = by_fv - share * v_c, by_delay - share * r_c
        if self.law.drum:
            columns["drum"] = travel
            x = x + p["drum"] * travel
        by_own = -np.stack([columns[name] for name in self.law.names], axis=-1)
        of_winding = np.zeros((*travel.shape, 0))
        return ClockRows(travel - x, travel_d - x_d, -by_delay, -by_fv, of_winding, by_own)


def _slope(powers: list[Array], tension: Array) -> Array:
    """dx/dt of the polynomial, m/N."""
    u = tension / NEWTON
    return np.asarray(sum(k * g * u ** (k - 1) for k, g in enumerate(powers, 1)) / NEWTON)


def part_of(frames: Frames, kept: Array | slice) -> Frames:
    """Some of the frames."""
    arrays = {
        name: getattr(frames, name)[kept]
        for name in ("time", "alpha", "sigma", "winding", "Z", "solver", "by_model", "by_dimension")
    }
    return Frames(**arrays, middle=frames.middle)


def whitening(frames: Frames, model_error: float, scale: float = 1.0) -> Array:
    """(F, M, M): what makes a frame's residuals independent and of unit variance."""
    cables = frames.Z.shape[2]
    covariance = np.einsum("fij,fi,fik->fjk", frames.Z, (scale * frames.sigma) ** 2, frames.Z)
    covariance += model_error**2 * np.eye(cables)
    return np.linalg.inv(np.linalg.cholesky(covariance))


def errors_seen(frames: Frames, residual: Array) -> tuple[float, float]:
    """(model error in m, true over stated noise of the angles): what of the residuals no angles explain, and what they do."""
    n, m = frames.Z.shape[1:]
    turned = np.einsum("fij,fj->fi", frames.solver, residual)
    beside = residual - np.einsum("fij,fi->fj", frames.Z, turned)
    model = LEAST_ERROR if m <= n else max(float(np.sqrt(np.mean(np.sum(beside**2, axis=1)) / (m - n))), LEAST_ERROR)
    by_model = model**2 * frames.by_model
    square = float(np.mean((turned**2 - by_model) / frames.sigma**2))
    return model, float(np.sqrt(max(square, LEAST_SCALE**2)))
