"""What is known to a tolerance only: numbers of the drawing, the angles' zeros, friction's curve, forces' scale, and clocks.

Within its tolerance nothing is a cause. Each is a number with the tolerance as its prior's standard deviation. How far it goes is
what the recordings say, up to MAX_TOLERANCES: a model that lacks something would drive it anywhere, and the laws with it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from diagnosis.angle_zeros import angle_errors_of_bars
from diagnosis.force_scale import force_scale_columns
from diagnosis.friction_curve import friction_curve_columns
from diagnosis.hypothesis import Hypothesis
from diagnosis.linearisation import Linearisation, RecordingLinearisation
from identification.residual_sensitivity import AngleError
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.toleranced_numbers import TolerancedNumber, moved, toleranced_numbers
from xneck_foundation.document_faults import described_faults
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

MAX_TOLERANCES = 4.0
"""standard deviations up to which a number may be off its drawing (docs/thresholds.md)"""
_MIN_CLOCK_SIGMA_S = 1e-5
"""s: sigma of clocks that came without one (docs/thresholds.md)"""


@dataclass(frozen=True)
class Nuisances:
    """What small errors of the arm, of the angles and of the clocks do to the residuals."""

    drawing: tuple[TolerancedNumber, ...]
    """numbers of the description"""
    zero_sigma: float
    """rad, of the markers of each bar, from the base's on, against it; 0 where they are exact"""
    bar_errors: Array
    """what one radian of each bar's markers adds to each joint angle, (N + 1, N); (0, N) where they are exact"""
    arm_columns: tuple[Array, ...]
    """of each recording: what one sigma of each of the arm's, the angles', friction's and the forces' does, (C, S, Q)"""
    clock_columns: tuple[Array, ...]
    """of each recording: what one sigma of its clock's offset and skew does, (C, S, 2)"""
    clock_sigma: tuple[float, ...]
    """s: of each recording's offset"""
    clock_relaxation: tuple[float, ...]
    """factor on each `clock_sigma` where the laws that the clock rests on are wrong"""
    departures: Array
    """(Q,), sigmas by which each is off what was drawn where columns are told"""

    @property
    def count(self) -> int:
        """Q, of the arm's, the angles', friction's curve and the forces' scale."""
        return len(self.departures)

    @property
    def described_count(self) -> int:
        """Of the first ones, which neck.yaml or a data set's angles can say: the drawing's and the bars' markers."""
        return len(self.drawing) + len(self.bar_errors)

    def adjusted(self, h: Hypothesis, numbers: Array) -> Hypothesis:
        """A hypothesis with the arm's and the angles' moved by numbers (Q,) of their sigmas; friction and forces stay."""
        of_drawing, of_bars, of_forces = np.split(numbers, [len(self.drawing), self.described_count])
        neck = moved(h.neck, self.drawing, [n.sigma * x for n, x in zip(self.drawing, of_drawing, strict=True)])
        try:
            neck = Neck.model_validate(neck.model_dump())
        except ValidationError as error:
            what = "the recordings ask for a description that no arm can have"
            raise Refused("diagnose", f"{what}: {described_faults(error.errors(), Neck, neck.model_dump())}") from error
        departures = self.departures + np.concatenate([of_drawing, of_bars, 0 * of_forces])
        angle_error = h.angle_error + self.zero_sigma * of_bars @ self.bar_errors
        return replace(h, neck=neck, angle_error=angle_error, departures=tuple(departures.tolist()))


def nuisances_at(at: Linearisation) -> Nuisances:
    """At a linearisation; nearby they are the same."""
    neck = at.hypothesis.neck
    drawing = tuple(number for number in toleranced_numbers(neck) if number.sigma > 0)
    zero_sigma = neck.tolerance.marker_angle
    clock_sigma = tuple(max(r.signals.clock_sigma[0], _MIN_CLOCK_SIGMA_S) for r in at.recordings)
    arm_columns = tuple(_arm_columns(recording, neck, drawing, zero_sigma) for recording in at.recordings)
    return Nuisances(
        drawing=drawing,
        zero_sigma=zero_sigma,
        bar_errors=angle_errors_of_bars(neck.N)[: None if zero_sigma > 0 else 0],
        arm_columns=arm_columns,
        clock_columns=tuple(_clock_columns(r, sigma) for r, sigma in zip(at.recordings, clock_sigma, strict=True)),
        clock_sigma=clock_sigma,
        clock_relaxation=tuple(
            max(1.0, r.signals.relaxed_clock_sigma / sigma) for r, sigma in zip(at.recordings, clock_sigma, strict=True)
        ),
        departures=np.array(at.hypothesis.departures or (0.0,) * arm_columns[0].shape[2]),
    )


def _arm_columns(
    recording: RecordingLinearisation, neck: Neck, drawing: Sequence[TolerancedNumber], zero_sigma: float
) -> Array:
    """What one sigma of the arm's numbers, the angles' zeros, friction's curve and forces' scale does, (C, S, Q)."""
    change = recording.sensitivity.residual_change
    columns = [change(arm=arm_of(number.moved(neck, number.sigma))) for number in drawing]
    if zero_sigma > 0:
        errors = zero_sigma * angle_errors_of_bars(neck.N)
        columns += [change(angle_error=AngleError(-error)) for error in errors]
    of_arm = np.stack(columns, axis=-1) if columns else np.zeros((*recording.rows.residual.shape, 0))
    of_forces = [
        columns_of(recording, share)
        for columns_of, share in (
            (friction_curve_columns, neck.tolerance.friction_curve),
            (force_scale_columns, neck.tolerance.drum),
        )
        if share > 0
    ]
    return np.concatenate([of_arm, *of_forces], axis=2)


def _clock_columns(recording: RecordingLinearisation, offset_sigma: float) -> Array:
    """What one sigma of the recording's clock does: its offset's (s) and its skew's, (C, S, 2)."""
    s, sensitivity = recording.signals, recording.sensitivity
    age = s.time[s.low_pass.kept] - s.time.mean()
    shifts = (sensitivity.error_of_lag(offset_sigma), sensitivity.error_of_lag(s.clock_sigma[1] * age))
    return np.stack([sensitivity.residual_change(angle_error=shift) for shift in shifts], axis=-1)
