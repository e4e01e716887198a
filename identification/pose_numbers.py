"""The numbers that put the arm where the camera saw it: of the drawing, of the laws, and of each recording, with their priors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identification.model_file import Model, covariance_of, machine_of
from identification.pose_rows import PoseRows
from identification.unknowns import terms_of
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.laws import Term
from mechanism.toleranced_numbers import TolerancedNumber, toleranced_numbers

MARKER_OFFSET = "marker_offset"
"""name of by how much the camera sees a joint's angle beside that of the bars"""
DRAGGED = "dragged"
"""name of the share of a motor's speed that its cable's damper feels while the motor crosses its play"""
DRAGGED_SIGMA = 0.6
"""of that share: anything between none, as the law has it, and all is as likely (docs/thresholds.md)"""
_MAX_MARKER_OFFSET_RAD = 0.2
"""rad, of what is sought (docs/thresholds.md)"""
_UNTOLD_STIFFNESS = 5e3
"""N/m: as `identify` begins"""
_X0_SIGMA_M = 3e-3
"""of a pre-elongation, from the one that the motors' forces tell (docs/thresholds.md)"""
_LAW_RANGE_SHARE = 0.25
"""share of a law's range that is its number's prior sigma at most (docs/thresholds.md)"""
_LAW_SIGMAS = 3.0
"""by how much the sigmas of `identify` are widened: they hold if the drawing is right (docs/thresholds.md)"""
_MIN_LAW_SIZES = 0.5
"""sizes of a term that its prior sigma is at least (docs/thresholds.md)"""


@dataclass(frozen=True)
class SoughtNumber:
    """One number that is sought: of the drawing, a law, or a recording."""

    name: str
    index: int | None
    mean: float
    sigma: float
    low: float
    high: float
    drawing: TolerancedNumber | None = None
    recording: int | None = None

    @property
    def kind(self) -> Literal["drawing", "law", "x0", "markers"]:
        """As the model's file has it."""
        if self.drawing is not None:
            return "drawing"
        return "x0" if self.name == "x0" else "markers" if self.name == MARKER_OFFSET else "law"


def is_shape(term: Term) -> bool:
    """Whether a law's term says how it acts, not how much: such as a time constant. It stays as `identify` left it."""
    return term.of == "arm" and (not term.linear or (term.low > 0 and term.name != "E"))


def sought_numbers(neck: Neck, model: Model, rows: Sequence[PoseRows]) -> list[SoughtNumber]:
    """The numbers that are sought, in the order of the fit; pre-elongations as if there were none (pose_start.py)."""
    out = [
        SoughtNumber(name=n.name, index=None, mean=0.0, sigma=n.sigma, low=-0.5, high=0.5, drawing=n)
        for n in toleranced_numbers(neck)
        if n.sigma > 0
    ]
    # a joint's angle is that between the markers of two bars
    between, most = float(np.sqrt(2)) * neck.tolerance.marker_angle, _MAX_MARKER_OFFSET_RAD
    if between > 0:
        out += [
            SoughtNumber(name=MARKER_OFFSET, index=i + 1, mean=0.0, sigma=between, low=-most, high=most)
            for i in range(neck.N)
        ]
    arm = arm_of(neck)
    machine = machine_of(model, arm)
    values = machine.values
    known = {(p.name, p.index): i for i, p in enumerate(model.parameters)}
    variances = np.diag(covariance_of(model))
    for term in terms_of(model.laws):
        if is_shape(term):
            continue
        span = term.high - term.low
        most = _LAW_RANGE_SHARE * span if np.isfinite(span) else np.inf
        for i in range(term.count(arm)):
            index = None if term.of == "arm" else i + 1
            value = float(values[term.name][i])
            place = known.get((term.name, index))
            sigma = np.inf if place is None else float(np.sqrt(variances[place]))
            sure = place is not None and model.parameters[place].identified
            if not sure and term.name == "k":
                # what `identify` could not tell may have gone anywhere, and its sigma with it
                value = sigma = _usual_stiffness(model)
            if not sure and term.name not in ("k", "E"):
                value = min(max(value, -2 * term.size), 2 * term.size) if np.isfinite(span) else value
            sigma = min(max(_LAW_SIGMAS * sigma, _MIN_LAW_SIZES * term.size), most)
            if not np.isfinite(sigma):
                sigma = max(abs(value), term.size)
            out.append(SoughtNumber(name=term.name, index=index, mean=value, sigma=sigma, low=term.low, high=term.high))
    for r, recording in enumerate(rows):
        for j in range(arm.M):
            out.append(
                SoughtNumber(name="x0", index=j + 1, mean=0.0, sigma=_X0_SIGMA_M, low=-0.05, high=0.05, recording=r)
            )
            if machine.play_place is not None:
                out.append(
                    SoughtNumber(
                        name=DRAGGED, index=j + 1, mean=0.0, sigma=DRAGGED_SIGMA, low=-1.0, high=2.0, recording=r
                    )
                )
        out.append(
            SoughtNumber(
                name="clock", index=None, mean=0.0, sigma=recording.clock_sigma, low=-0.05, high=0.05, recording=r
            )
        )
        out.append(
            SoughtNumber(
                name="skew", index=None, mean=0.0, sigma=recording.skew_sigma, low=-1e-3, high=1e-3, recording=r
            )
        )
    return out


def _usual_stiffness(model: Model) -> float:
    """Median stiffness of the cables whose stiffness was identified, N/m; else that with which fits begin."""
    told = [p.value for p in model.parameters if p.name == "k" and p.identified]
    return float(np.median(told)) if told else _UNTOLD_STIFFNESS
