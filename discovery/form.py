"""Forms of a law, simplest first: columns of one variable, each with an amount, under inner constants that say how it acts."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from discovery.fine_basis import HARMONICS, FineBasis

Array = NDArray[np.float64]
Constants = Mapping[str, float]
Kind = Literal["turn", "line", "arc", "time"]
"""of a variable: what comes round with a turn, any other, one along which a law may come again, and time"""

_LINES: tuple[Kind, ...] = ("line", "arc")
"""kinds of what never comes round"""

_PLACES = np.linspace(0.08, 0.92, 15)
"""shares of a variable's range at which a bump or a hinge is tried"""
_WIDTHS = (0.04, 0.08, 0.15)
"""of a bump, in shares of the range"""
_TURN_PLACES, _TURN_WIDTHS = 24, (0.15, 0.3, 0.6, 1.0)
"""rad"""
_STEP_PLACES, _STEP_WIDTHS = np.linspace(0.04, 0.96, 24), (0.001, 0.02)
"""the same of a step: all at once, and slowly"""
_LEVELS = (0.08, 0.15, 0.3, 0.5, 0.8, 1.5)
"""where a saturating law bends, in shares of the largest size"""
_ROUNDNESS = (1.0, 3.0)
"""exponents of a saturating law: as slow as an arc tangent, and as soon as a hyperbolic one"""
_FREE_SHARES = (0.08, 0.15, 0.3, 0.45, 0.6, 0.75)
"""of the largest size, within which nothing acts"""
_WAVES = np.arange(0.75, 3.6, 0.25)
"""in the whole range of a variable"""
_TIMES = (0.08, 0.15, 0.3, 0.6, 1.2)
"""of an exponential, in shares of the time"""
SMOOTH = "smooth"
"""name of the form of what has no simple one"""
SMOOTH_PIECES = 9
"""of a smooth function along its variable"""
SMOOTH_HARMONICS = 6
"""of a smooth function of a turn"""


@dataclass(frozen=True)
class Form:
    """One form."""

    name: str
    kinds: tuple[Kind, ...]
    rank: int
    """the lower the simpler: where two explain alike, the simpler one is taken"""
    amounts: tuple[str, ...]
    """names of what it is in proportion to"""
    columns: Callable[[Array, Constants], Array]
    """of values (..., T), (..., T, amounts); constants may be arrays that broadcast"""
    starts: Callable[[FineBasis], tuple[Constants, ...]]
    """inner constants that are tried"""
    equation: str
    """with x for the variable"""
    constants: tuple[str, ...] = ()
    """names of the inner constants"""
    fixed: tuple[str, ...] = ()
    """those that are counted, or that bound where the form is told: they are not fitted"""
    of_one_place: bool = False
    """whether it is looked for at one place at a time: it could stand for simpler ones of several"""

    def unit(self, name: str, target: str, variable: str) -> str:
        """The unit of an amount or an inner constant."""
        if name in self.amounts:
            power = {"a1": 1, "a2": 2, "a3": 3, "slope": 1}.get(name, 0)
            if power == 0 or variable == "1":
                return target
            return "1" if power == 1 and variable == target else f"{target}/{_powered(variable, power)}"
        if name == "wavenumber":
            return "1" if variable == "1" else f"1/{variable}"
        return "1" if name in ("count", "side", "exponent") else variable


def _powered(unit: str, power: int) -> str:
    plain = unit if not set("/ ") & set(unit) else f"({unit})"
    return plain if power == 1 else f"{plain}^{power}"


def _none(basis: FineBasis) -> tuple[Constants, ...]:
    return ({},)


def _stack(*columns: Array) -> Array:
    return np.stack(np.broadcast_arrays(*columns), axis=-1)


def _polynomial(degree: int) -> Form:
    powers = range(1, degree + 1)
    return Form(
        name="polynomial",
        kinds=(*_LINES, "time"),
        rank=degree - 1,
        amounts=tuple(f"a{n}" for n in powers),
        columns=lambda x, c: _stack(*(x**n for n in powers)),
        starts=_none,
        equation=" + ".join(f"a{n} x^{n}" if n > 1 else "a1 x" for n in powers),
    )


def _cosine_and_sine(of: str) -> Callable[[Array, Constants], Array]:
    """Of a variable times the constant of a name."""
    return lambda x, c: _stack(np.cos(c[of] * x), np.sin(c[of] * x))


def _counts_to(most: int) -> Callable[[FineBasis], tuple[Constants, ...]]:
    return lambda basis: tuple({"count": float(n)} for n in range(1, most + 1))


def _with_overtone(x: Array, c: Constants) -> Array:
    cosine, sine = np.cos(c["count"] * x), np.sin(c["count"] * x)
    return _stack(cosine, sine, 2 * cosine**2 - 1, 2 * sine * cosine)


def _smooth_on_turn(x: Array, c: Constants) -> Array:
    cosines, sines = [np.cos(x)], [np.sin(x)]
    while len(cosines) < SMOOTH_HARMONICS:  # products are sooner made than waves
        cosine, sine = cosines[-1], sines[-1]
        cosines.append(cosine * cosines[0] - sine * sines[0])
        sines.append(sine * cosines[0] + cosine * sines[0])
    return _stack(*cosines, *sines)


def _bump(x: Array, c: Constants) -> Array:
    return np.exp(-(((x - c["place"]) / c["width"]) ** 2))[..., None]


def _places_and_widths(basis: FineBasis, places: Iterable[float], widths: Iterable[float]) -> tuple[Constants, ...]:
    """In shares of the range."""
    span = basis.high - basis.low
    return tuple({"place": basis.low + p * span, "width": w * span} for p in places for w in widths)


def _turn_bump(x: Array, c: Constants) -> Array:
    away = 2 * np.sin((x - c["place"]) / 2)  # |exp(i (x - place)) - 1|, but for its sign
    return np.exp(-((away / c["width"]) ** 2))[..., None]


def _turn_bump_starts(basis: FineBasis) -> tuple[Constants, ...]:
    places = np.arange(_TURN_PLACES) * 2 * np.pi / _TURN_PLACES
    return tuple({"place": float(p), "width": w} for p in places for w in _TURN_WIDTHS)


def _hinge_starts(basis: FineBasis) -> tuple[Constants, ...]:
    span = basis.high - basis.low
    return tuple({"place": basis.low + p * span, "side": side} for p in _PLACES for side in (1.0, -1.0))


def _truncated_power_starts(basis: FineBasis) -> tuple[Constants, ...]:
    further = tuple({"exponent": n, "size": basis.high - basis.low} for n in (2.0, 3.0))
    return tuple({**at, **power} for at in _hinge_starts(basis) for power in further)


def _truncated_power(x: Array, c: Constants) -> Array:
    return ((np.maximum(c["side"] * (x - c["place"]), 0.0) / c["size"]) ** c["exponent"])[..., None]


def _step(x: Array, c: Constants) -> Array:
    return (0.5 * (1 + np.tanh((x - c["place"]) / c["width"])))[..., None]


def _size(basis: FineBasis) -> float:
    """The largest size of a variable, to two digits."""
    return float(f"{max(abs(basis.low), abs(basis.high)):.1e}")


def _power(x: Array, c: Constants) -> Array:
    return (np.sign(x) * np.abs(x / c["size"]) ** c["exponent"])[..., None]


def _levels(basis: FineBasis) -> tuple[Constants, ...]:
    return tuple({"level": share * _size(basis)} for share in _LEVELS)


def _times(basis: FineBasis) -> tuple[Constants, ...]:
    return tuple({"tau": share * (basis.high - basis.low), "begin": basis.low} for share in _TIMES)


def _saturated(u: Array, exponent: Array | float) -> Array:
    """Of u from nothing on: in proportion, then one; the larger the exponent the sooner, with 2.7 much as tanh."""
    most = np.maximum(u, 1.0)  # powers of what is no more than one go nowhere
    return u / most / ((1 / most) ** exponent + (u / most) ** exponent) ** (1 / exponent)


def _saturation(x: Array, c: Constants) -> Array:
    return (np.sign(x) * _saturated(np.abs(x) / c["level"], c["exponent"]))[..., None]


def _one_sided_saturation(x: Array, c: Constants) -> Array:
    return _saturated(np.maximum(c["side"] * x, 0.0) / c["level"], c["exponent"])[..., None]


def _saturation_starts(basis: FineBasis) -> tuple[Constants, ...]:
    return tuple({**at, "exponent": n} for at in _levels(basis) for n in _ROUNDNESS)


def _one_sided_saturation_starts(basis: FineBasis) -> tuple[Constants, ...]:
    return tuple({**at, "side": side} for at in _saturation_starts(basis) for side in (1.0, -1.0))


def _smooth(x: Array, c: Constants) -> Array:
    at = (np.clip(x, c["low"], c["high"]) - c["low"]) / (c["high"] - c["low"]) * (SMOOTH_PIECES - 1)
    return np.maximum(0.0, 1 - np.abs(at[..., None] - np.arange(SMOOTH_PIECES)))


FORMS = (
    _polynomial(1),
    Form(
        name="harmonic",
        kinds=("turn",),
        rank=1,
        amounts=("cosine", "sine"),
        columns=_cosine_and_sine("count"),
        starts=_counts_to(HARMONICS),
        equation="cosine cos(count x) + sine sin(count x)",
        constants=("count",),
        fixed=("count",),
    ),
    Form(
        name="harmonic with overtone",
        kinds=("turn",),
        rank=2,
        amounts=("cosine", "sine", "cosine2", "sine2"),
        columns=_with_overtone,
        starts=_counts_to(HARMONICS // 2),
        equation="cosine cos(count x) + sine sin(count x) + cosine2 cos(2 count x) + sine2 sin(2 count x)",
        constants=("count",),
        fixed=("count",),
        of_one_place=True,
    ),
    Form(
        name="power",
        kinds=_LINES,
        rank=1,
        amounts=("height",),
        columns=_power,
        starts=lambda basis: tuple({"exponent": n, "size": _size(basis)} for n in (0.5, 1.5, 2.0, 2.5, 3.0)),
        equation="height sign(x) (|x| / size)^exponent",
        constants=("exponent", "size"),
        fixed=("size",),
    ),
    _polynomial(2),
    Form(
        name="exponential",
        kinds=("time",),
        rank=2,
        amounts=("height",),
        columns=lambda x, c: np.exp(-(x - c["begin"]) / c["tau"])[..., None],
        starts=_times,
        equation="height exp(-(x - begin) / tau)",
        constants=("tau", "begin"),
        fixed=("begin",),
    ),
    Form(
        name="hinge",
        kinds=(*_LINES, "time"),
        rank=2,
        amounts=("slope",),
        columns=lambda x, c: np.maximum(c["side"] * (x - c["place"]), 0.0)[..., None],
        starts=_hinge_starts,
        equation="slope max(side (x - place), 0)",
        constants=("place", "side"),
        fixed=("side",),
    ),
    Form(
        name="step",
        kinds=("time",),
        rank=2,
        amounts=("height",),
        columns=_step,
        starts=lambda basis: _places_and_widths(basis, _STEP_PLACES, _STEP_WIDTHS),
        equation="height (1 + tanh((x - place) / width)) / 2",
        constants=("place", "width"),
        fixed=("width",),
    ),
    Form(
        name="saturating",
        kinds=_LINES,
        rank=2,
        amounts=("height",),
        columns=_saturation,
        starts=_saturation_starts,
        equation="height sign(x) u / (1 + u^exponent)^(1 / exponent), u = |x| / level",
        constants=("level", "exponent"),
    ),
    _polynomial(3),
    Form(
        name="dead zone",
        kinds=_LINES,
        rank=3,
        amounts=("slope",),
        columns=lambda x, c: (np.sign(x) * np.maximum(np.abs(x) - c["level"], 0.0))[..., None],
        starts=lambda basis: tuple({"level": share * _size(basis)} for share in _FREE_SHARES),
        equation="slope sign(x) max(|x| - level, 0)",
        constants=("level",),
    ),
    Form(
        name="saturating on one side",
        kinds=_LINES,
        rank=3,
        amounts=("height",),
        columns=_one_sided_saturation,
        starts=_one_sided_saturation_starts,
        equation="height u / (1 + u^exponent)^(1 / exponent), u = max(side x, 0) / level",
        constants=("level", "exponent", "side"),
        fixed=("side",),
    ),
    Form(
        name="truncated power",
        kinds=_LINES,
        rank=3,
        amounts=("height",),
        columns=_truncated_power,
        starts=_truncated_power_starts,
        equation="height (max(side (x - place), 0) / size)^exponent",
        constants=("place", "side", "exponent", "size"),
        fixed=("side", "size"),
    ),
    Form(
        name="wave",
        kinds=("arc",),
        rank=3,
        amounts=("cosine", "sine"),
        columns=_cosine_and_sine("wavenumber"),
        starts=lambda basis: tuple({"wavenumber": 2 * np.pi * n / (basis.high - basis.low)} for n in _WAVES),
        equation="cosine cos(wavenumber x) + sine sin(wavenumber x)",
        constants=("wavenumber",),
    ),
    Form(
        name="bump",
        kinds=(*_LINES, "time"),
        rank=3,
        amounts=("height",),
        columns=_bump,
        starts=lambda basis: _places_and_widths(basis, _PLACES, _WIDTHS),
        equation="height exp(-((x - place) / width)^2)",
        constants=("place", "width"),
    ),
    Form(
        name="bump",
        kinds=("turn",),
        rank=3,
        amounts=("height",),
        columns=_turn_bump,
        starts=_turn_bump_starts,
        equation="height exp(-(|exp(i (x - place)) - 1| / width)^2)",
        constants=("place", "width"),
    ),
    Form(
        name="levelling off",
        kinds=_LINES,
        rank=3,
        amounts=("slope", "height"),
        columns=lambda x, c: _stack(x, np.tanh(x / c["level"])),
        starts=_levels,
        equation="slope x + height tanh(x / level)",
        constants=("level",),
    ),
    Form(
        name=SMOOTH,
        kinds=(*_LINES, "time"),
        rank=9,
        amounts=tuple(f"h{i}" for i in range(1, SMOOTH_PIECES + 1)),
        columns=_smooth,
        starts=lambda basis: ({"low": basis.low, "high": basis.high},),
        equation="straight between h1 .. h9, evenly spaced from low to high",
        constants=("low", "high"),
        fixed=("low", "high"),
    ),
    Form(
        name=SMOOTH,
        kinds=("turn",),
        rank=9,
        amounts=tuple(f"{of}{n}" for of in ("cosine", "sine") for n in range(1, SMOOTH_HARMONICS + 1)),
        columns=_smooth_on_turn,
        starts=_none,
        equation="cosine1 cos(x) + sine1 sin(x) + .. + cosine6 cos(6 x) + sine6 sin(6 x)",
        of_one_place=True,
    ),
)
"""all, simplest first"""


def forms_of(kind: Kind) -> tuple[Form, ...]:
    """The forms that a function of a variable of a kind may have."""
    return tuple(form for form in FORMS if kind in form.kinds)
