"""Which numbers a motion tells, and of the others why not and what would tell them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from identification.fasquelle.method import WELL_IDENTIFIED
from identification.fitting import NOT_TOLD, Solution, blind
from identification.unknowns import Unknown, Unknowns
from mechanism.laws import LAWS, Law

Array = NDArray[np.float64]

_NUISANCES = ("x0", "delay")
"""zero is a value like any other for them: known where sigma is below what a person calls a change"""
_TIED = 0.9
"""a correlation from which one number is traded off against the other"""
_TOLD = 3.0
"""sigmas by which a value differs from nothing"""

WANTED = {
    "k": "vary the cable's tension by tens of newtons",
    "E": "vary the cables' tension by tens of newtons",
    "ca": "vary the tension at 2 Hz and faster, with a clock known to 0.1 ms (a light that the controller switches)",
    "c": "vary the tension at 2 Hz and faster, with a clock known to 0.1 ms (a light that the controller switches)",
    "fs": "turn the motor both ways at speed, many times",
    "cm": "reverse the motors often and slowly",
    "fv": "turn the motor at speeds that differ several times over",
    "fst": "creep through rest as well as move fast",
    "vs": "creep through rest as well as move fast",
    "mu": "vary the tension while the motors turn",
    "k2": "vary the tension over its whole range, apart from the motion",
    "nh": "vary the tension over its whole range, apart from the motion",
    "ns": "creep through rest as well as move fast",
    "vj": "swing the joints fast, with cables of little friction",
    "nj": "swing the joints fast, with cables of little friction",
    "g": "carry known weights",
    "fo": "carry known weights",
    "taul": "reverse the motors often",
    "play": "reverse the motors often and slowly",
    "slack": "let the tension come near to nothing",
    "xt": "let the tension come near to nothing",
    "km": "step the tension and hold it for a while",
    "tau": "step the tension and hold it for a while",
    "h": "vary the tension slowly up and down by different amounts",
    "xh": "vary the tension slowly up and down by different amounts",
    "cj": "swing the joints fast, with cables of little friction",
    "dj": "swing the joints fast, with cables of little friction",
    "x0": "vary the cable's tension by tens of newtons",
    "delay": "reverse the motors often",
}
"""what to record, by term"""

ELASTIC = {term.name for law in LAWS.values() if type(law).pull is not Law.pull for term in law.terms}
"""terms of laws by which cables pull"""


@dataclass(frozen=True)
class Verdict:
    """Whether a number is identified; if not, the reason in words, and the motion that would tell it."""

    identified: bool
    kind: str
    """identified, dead, flat, traded, bound or nothing (not told apart from zero)"""
    why: str = ""
    record: str = ""


def judge(u: Unknowns, found: Solution) -> tuple[Verdict, ...]:
    """One verdict for each entry of the vector."""
    sigma = np.sqrt(np.diag(found.covariance))
    safe = np.where((sigma > 0) & np.isfinite(sigma), sigma, 1.0)
    correlation = np.where(np.isfinite(found.covariance), found.covariance, 0.0) / np.outer(safe, safe)
    nothing = blind(found.information, ~found.at_bound)
    unseen = np.diag(nothing) > NOT_TOLD
    part = np.sqrt(np.where(unseen, np.diag(nothing), 1.0))
    correlation = np.where(np.outer(unseen, unseen), nothing / np.outer(part, part), correlation)
    return tuple(_judged(u, found, place, sigma, correlation) for place in range(len(u.entries)))


def _judged(u: Unknowns, found: Solution, place: int, sigma: Array, correlation: Array) -> Verdict:
    entry, value, own = u.entries[place], float(found.p[place]), float(sigma[place])
    record = WANTED.get(entry.term.name, "")
    if found.at_bound[place]:
        return Verdict(False, "bound", f"at its bound, {value:g} {entry.term.unit}", record)
    stuck = entry.term.of == "cable" and entry.term.name in ELASTIC and _x0_at_bound(u, found, entry.index)
    if stuck:
        return Verdict(
            False, "bound", f"insufficient: x0({entry.index}) is at its bound, vision's noise hides it", record
        )
    alone = float(found.information[place, place])
    if own == 0 or alone * (entry.term.high - entry.term.low) ** 2 < 1:
        return Verdict(False, "dead", "this motion does not show it", record)
    nuisance = entry.term.name in _NUISANCES
    enough = entry.term.size if nuisance else WELL_IDENTIFIED / 100 * abs(value)
    if own <= enough:
        return Verdict(True, "identified")
    others = np.abs(correlation[place])
    others[place] = 0.0
    other = int(np.argmax(others))
    if others[other] > _TIED:
        words = f"traded off against {label(u.entries[other])} (correlation {correlation[place, other]:+.2f})"
        return Verdict(False, "traded", words, record)
    if not nuisance and abs(value) < _TOLD * own:
        return Verdict(False, "nothing", "not told apart from zero", record)
    return Verdict(False, "flat", f"known to {100 * own / abs(value):.0f} % only" if value else "not known", record)


def _x0_at_bound(u: Unknowns, found: Solution, index: int | None) -> bool:
    """Whether a cable's stretch at rest ran away in any recording: then its stiffness is not the cable's."""
    return any(found.at_bound[i] for i, e in enumerate(u.entries) if e.term.name == "x0" and e.index == index)


def label(entry: Unknown) -> str:
    """As tables write it: k(2)."""
    return entry.term.name if entry.index is None else f"{entry.term.name}({entry.index})"


def durbin_wu_hausman(found: Solution) -> tuple[float, float]:
    """Statistic and probability that least squares differs that much from the instruments by chance alone.

    Over the terms whose columns the instruments replace (Hausman 1978); blocks stand for independent samples.
    """
    chosen = np.flatnonzero(found.touched & ~found.at_bound)
    if not len(chosen):
        return 0.0, 1.0
    apart = (found.p - found.least_squares)[chosen]
    spread = found.difference_covariance[np.ix_(chosen, chosen)]
    scale = np.sqrt(np.diag(spread))
    if np.any(scale == 0):
        return 0.0, 1.0
    apart, spread = apart / scale, spread / np.outer(scale, scale)
    q = int(np.linalg.matrix_rank(spread, tol=1e-8))
    statistic = float(apart @ np.linalg.pinv(spread, rcond=1e-8, hermitian=True) @ apart)
    left = max(found.blocks - q, 1)
    return statistic, float(f_distribution.sf(statistic * left / (q * max(found.blocks - 1, 1)), q, left))
