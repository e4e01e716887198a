"""The cables' equation of the clock: (rd/R) theta = w(alpha) + x, the elongation x explained by the force.

x = c + g(t) + creep, with the tension t = n - h dry(theta') - sum w_i form_i(theta') - fv theta' - ca x'. Each cable has a
polynomial g of its own; the forms make of dry(theta') any friction that turns over with the speed. Creep begins with the log as if
the cable had been at rest, and with a start of its own that fades: it may have been pulled just before. The force n may come late
by a delay and be off by an error of the motors' inertia; the winding w(alpha) may be off by errors of the arm's geometry. Offset
and skew move the log's signals against the camera's alpha. There is one row for every cable and frame.
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from identification.filters import first_order_lag
from mechanism.affine_steps import accumulated_within
from mechanism.drawing_errors import MOTOR_INERTIA_SIGMA
from synchronisation.clocks.frame_geometry import FrameGeometry
from synchronisation.clocks.signals import FRICTION_FORMS, LogSignals, cubic_spline
from synchronisation.clocks.unknowns import ClockUnknowns

Array = NDArray[np.float64]

FORCE_SCALE_N = 50.0
"""N: tensions are divided by this, so that powers of them stay near one"""
MIN_COMPLIANCE_M_N = 1e-6
"""m/N: no cable of an arm is stiffer; a polynomial may be where nothing tells it (docs/thresholds.md)"""
MAX_LAG_S = 0.5
"""s: the most that a damped cable may lag behind its force; a lower limit pulls the clock where it is met (docs/thresholds.md)"""
PRIOR_SIGMA = {
    "c": 0.1, "g": 0.05, "h": 2.0, "w": 0.4, "i": MOTOR_INERTIA_SIGMA, "ca": 10.0, "creep": 0.01, "start": 0.005,
    "drum": 0.1, "play": 1.0, "loop": 0.1,
}  # fmt: skip
"""weak prior of each kind of parameter, in m and FORCE_SCALE_N; a ratio for a drum, for a motor's inertia and for plays"""
PLAY_WIDTHS_M = (1e-4, 2e-4, 4e-4, 8e-4, 1.6e-3)
"""m of a motor's travel: widths of play operators whose weighted sum comes near any play about as wide (docs/thresholds.md)"""
LOOP_WIDTHS_N = (1.0, 2.0, 4.0, 8.0, 16.0)
"""N of a cable's tension: the same of hysteresis (docs/thresholds.md)"""
_FORMS = tuple(f"w{k + 1}" for k in range(FRICTION_FORMS))
"""names of the parameters of friction's forms"""
_MEMORIES = (
    *(f"play{k}" for k in range(len(PLAY_WIDTHS_M))),
    *(f"loop{k}" for k in range(len(LOOP_WIDTHS_N))),
)
"""names of the parameters of memory"""
_TENSION_PARTS = 5 + FRICTION_FORMS
"""signals that a tension consists of: force, dry friction and its forms, speed, the command's rate, the inertial force"""


@dataclass(frozen=True)
class CableTerms:
    """The terms of a cable's elongation."""

    powers: int = 3
    """highest power of the tension"""
    creep: tuple[float, ...] = (3.0,)
    """time constants, s"""
    damping: bool = True
    """elongation follows the force late, by ca"""
    friction_forms: bool = True
    """dry friction is of another form than the usual"""
    inertia: bool = True
    """motors' inertia is off"""
    drum: bool = False
    """drums' radii are off"""
    memory: float = 0.0
    """cables do not follow as motors turn round (play), or stretch otherwise as tension rises than as it falls (hysteresis): widths
    of the operators for it over the usual ones; 0 without"""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of a cable's parameters (K,), in their order."""
        powers = tuple(f"g{p + 1}" for p in range(self.powers))
        creep = tuple(f"{name}{k}" for name in ("creep", "start") for k in range(len(self.creep)))
        forms = tuple((name, self.friction_forms) for name in _FORMS)
        memories = tuple((name, self.memory > 0) for name in _MEMORIES)
        optional = (*forms, ("i", self.inertia), ("ca", self.damping), ("drum", self.drum), *memories)
        return ("c", *powers, "h", *(name for name, included in optional if included), *creep)

    @property
    def form_columns(self) -> list[int]:
        """Places of the parameters of friction's forms among a cable's, (W,) or none."""
        return [self.names.index(name) for name in _FORMS] if self.friction_forms else []

    @property
    def prior_sigma(self) -> Array:
        """Standard deviation of each parameter around zero, (K,): it keeps terms that nothing excites at zero."""
        return np.array([PRIOR_SIGMA.get(name.rstrip("0123456789"), 1.0) for name in self.names])


@dataclass(frozen=True)
class CableRows:
    """Rows of the cables' equation: F frames, M cables; residual in m, its slopes by the unknowns."""

    residual: Array
    """(F, M), m: travel less winding less elongation"""
    by_offset: Array
    """(F, M), m/s"""
    by_delay: Array
    """(F, M), m/s"""
    by_fv: Array
    """(F, M), of each motor's own fv"""
    by_geometry: Array
    """(F, M, P), m"""
    by_parameter: Array
    """(F, M, K), of each cable's own parameters"""
    tension: Array
    """(F, M), N: force less what friction takes by its law"""
    compliance: Array
    """(F, M), m/N, positive"""
    at_rest: NDArray[np.bool_]
    """(F, M): the motor is at rest, where friction may hold it at any force"""


class CableEquation:
    """The curves of a log that a law of the cables needs, and the rows that they give for any estimate of the unknowns."""

    def __init__(self, signals: LogSignals, law: CableTerms, tau: Array | float = 0.0, fs: Array | float = 0.0) -> None:
        """tau: (M,), s, time constants by which damped cables lag behind their forces; fs: (M,), N, dry friction of the motors, by
        which the tension that cables remember is told."""
        self.law = law
        self._signals, self._fs = signals, fs
        self._mean_force = signals.tension_parts[:, 0].mean(axis=0)
        self._time = signals.time
        self._span = (signals.time[0], signals.time[-1])
        travel = signals.travel(signals.time)[:, None]
        if law.memory > 0:
            travel = np.concatenate([travel, play_lag(travel[:, 0], law.memory * np.array(PLAY_WIDTHS_M))], axis=1)
        self._travel_curves = cubic_spline(signals.time, np.moveaxis(travel, 1, 2))
        self._let_lag(np.broadcast_to(np.asarray(tau, dtype=float), self._mean_force.shape))

    def _let_lag(self, tau: Array) -> None:
        """Makes the curves of the tension for time constants (M,), s."""
        s, law, step = self._signals, self.law, float(self._time[1] - self._time[0])
        self.tau = tau
        parts = first_order_lag(s.tension_parts, 1 / step, tau)
        curves = [parts, *(first_order_lag(parts, 1 / step, creep_s) for creep_s in law.creep)]
        if law.memory > 0:
            tension = (parts[:, 0] - self._fs * parts[:, 1]) / FORCE_SCALE_N
            curves.append(play_lag(tension, law.memory * np.array(LOOP_WIDTHS_N) / FORCE_SCALE_N))
        self._tension_curves = cubic_spline(s.time, np.moveaxis(np.concatenate(curves, axis=1), 1, 2))

    def with_lag(self, tau: Array) -> "CableEquation":
        """The same with other time constants, (M,), s."""
        other = copy(self)
        other._let_lag(tau)
        return other

    def lag(self, parameters: Array) -> Array:
        """Time constants ca g' of the cables at their mean force, (M,), s, for parameters (M, K)."""
        p = dict(zip(self.law.names, parameters.T, strict=True))
        if not self.law.damping:
            return np.zeros(len(parameters))
        powers = [p[f"g{k + 1}"] for k in range(self.law.powers)]
        return np.clip(p["ca"] * FORCE_SCALE_N * _compliance(powers, self._mean_force), 0.0, MAX_LAG_S)

    def initial_parameters(self, frames: FrameGeometry, offset: float) -> Array:
        """Parameters (M, K) from a linear fit of constant, force and dry friction at an offset, s."""
        at = np.clip(frames.time + offset, *self._span)
        travel = self._travel_curves(at)[..., 0]
        n, d = np.moveaxis(self._tension_curves(at)[..., :2], -1, 0)
        names = self.law.names
        out = np.zeros((travel.shape[1], len(names)))
        for j in range(len(out)):
            D = np.column_stack([np.ones(len(n)), n[:, j] / FORCE_SCALE_N, d[:, j]])
            c, g, h = np.linalg.lstsq(D, travel[:, j] - frames.winding[:, j], rcond=None)[0]
            out[j, names.index("c")], out[j, names.index("g1")] = c, g
            out[j, names.index("h")] = np.clip(-h / g, -1.0, 1.0) if abs(g) > 1e-6 else 0.0
        return out

    def rows(self, frames: FrameGeometry, unknowns: ClockUnknowns) -> CableRows:
        """Residuals and slopes at every frame."""
        at = frames.time + unknowns.offset + unknowns.skew * (frames.time - frames.middle)
        rows = self._rows_before_winding(np.clip(at, *self._span), unknowns)
        winding = frames.with_geometry_errors(unknowns.geometry_errors).winding
        return replace(rows, residual=rows.residual - winding, by_geometry=-frames.winding_by_geometry)

    def expected_winding(self, unknowns: ClockUnknowns) -> BSpline:
        """Travel less elongation over the log's time, (..., M), m: what the winding of true frames would be."""
        return cubic_spline(self._time, self._rows_before_winding(self._time, unknowns).residual)

    def _rows_before_winding(self, at: Array, unknowns: ClockUnknowns) -> CableRows:
        """Travel less elongation at log times (F,), s, as residual, with its slopes."""
        (travel, *plays), (travel_d, *play_rates) = (np.moveaxis(self._travel_curves(at, k), -1, 0) for k in (0, 1))
        parts, rates = ([*np.moveaxis(self._tension_curves(at, k), -1, 0)] for k in (0, 1))
        p = dict(zip(self.law.names, unknowns.cable_parameters.T, strict=True))
        zero = np.zeros(len(unknowns.cable_parameters))
        h, ca, *w = (p.get(name, zero) * FORCE_SCALE_N for name in ("h", "ca", *_FORMS))
        inertia = p.get("i", zero)
        powers = [p[f"g{k + 1}"] for k in range(self.law.powers)]

        def undamped(n: Array, d: Array, *others: Array) -> Array:
            *forms, v, r, i = others
            n = n - h * d - sum(share * form for share, form in zip(w, forms, strict=True))
            return n - unknowns.fv * v - unknowns.delay * r - inertia * i

        # the curves lag by tau already; the damping beyond it is small and taken to first order
        tension, tension_d = undamped(*parts[:_TENSION_PARTS]), undamped(*rates[:_TENSION_PARTS])
        x_d = _compliance(powers, tension) * tension_d
        t = tension - ca * x_d + self.tau * tension_d
        u, compliance = t / FORCE_SCALE_N, _compliance(powers, t)
        _, *frictions, v, r, i = parts[:_TENSION_PARTS]
        columns = {"c": np.ones_like(t)} | {f"g{k}": u**k for k in range(1, self.law.powers + 1)}
        x = p["c"] + sum(g * columns[f"g{k}"] for k, g in enumerate(powers, 1))
        for name, friction in zip(("h", *_FORMS), frictions, strict=True):
            columns[name] = -compliance * friction * FORCE_SCALE_N
        columns["i"], columns["ca"] = -compliance * i, -compliance * x_d * FORCE_SCALE_N
        by_fv, by_delay = -compliance * v, -compliance * r
        for k, creep_s in enumerate(self.law.creep):
            columns[f"start{k}"] = np.exp(-(at[:, None] - self._span[0]) / creep_s) * np.ones_like(t)
            x = x + p[f"start{k}"] * columns[f"start{k}"]
            creeping = parts[_TENSION_PARTS * (k + 1) : _TENSION_PARTS * (k + 2)]
            share = p[f"creep{k}"] / FORCE_SCALE_N
            columns[f"creep{k}"] = undamped(*creeping) / FORCE_SCALE_N
            x = x + p[f"creep{k}"] * columns[f"creep{k}"]
            _, *frictions, v_c, r_c, i_c = creeping
            for name, friction in zip(("h", *_FORMS), frictions, strict=True):
                columns[name] = columns[name] - share * friction * FORCE_SCALE_N
            columns["i"] = columns["i"] - share * i_c
            by_fv, by_delay = by_fv - share * v_c, by_delay - share * r_c
        if self.law.drum:
            columns["drum"] = travel
            x = x + p["drum"] * travel
        if self.law.memory > 0:
            lags, lag_rates = (
                [*of, *curves[-len(LOOP_WIDTHS_N) :]] for of, curves in ((plays, parts), (play_rates, rates))
            )
            for name, lag, lag_d in zip(_MEMORIES, lags, lag_rates, strict=True):
                columns[name] = -lag
                x, x_d = x - p[name] * lag, x_d - p[name] * lag_d
        return CableRows(
            residual=travel - x,
            by_offset=travel_d - x_d,
            by_delay=-by_delay,
            by_fv=-by_fv,
            by_geometry=np.zeros((*travel.shape, 0)),
            by_parameter=-np.stack([columns[name] for name in self.law.names], axis=-1),
            tension=t,
            compliance=np.maximum(compliance, MIN_COMPLIANCE_M_N),
            at_rest=self._signals.at_rest(at),
        )


def play_lag(path: Array, widths: Array) -> Array:
    """The play operators of widths (W,) less their argument, (T, W, M), of paths (T, M) in the widths' unit."""
    half = np.broadcast_to(widths[:, None] / 2, (len(widths), path.shape[1]))
    moved = np.broadcast_to(-np.diff(path, axis=0)[:, None], (len(path) - 1, *half.shape))
    return accumulated_within(np.zeros_like(half), moved, -half, half)


def _compliance(powers: list[Array], tension: Array) -> Array:
    """Slope dx/dt of the polynomial at a tension, m/N."""
    u = tension / FORCE_SCALE_N
    return np.asarray(sum(k * g * u ** (k - 1) for k, g in enumerate(powers, 1)) / FORCE_SCALE_N)
