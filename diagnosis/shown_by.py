"""Against which variable, and in which equation, an effect shows to the eye: what pictures draw and nothing is judged by."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from diagnosis.linearisation import RecordingLinearisation
from diagnosis.residual_conditions import tensions
from mechanism.cable_lengths import Z

Array = NDArray[np.float64]

_BENDS_SHOWN = 6.0
"""widths of the bristles: up to there the picture goes after each reversal"""
_CROSSINGS_SHOWN = 4.0
"""times the travel in which a motor crosses its play: up to there the picture goes after each reversal"""


@dataclass(frozen=True)
class ShownBy:
    """A variable of one motor or joint."""

    equation: Literal["motor", "joint"]
    name: str
    unit: str
    """SI; `turn` is one of a drum or motor"""
    values: Callable[[RecordingLinearisation, int], Array]
    """of a motor or joint, counted from 0, at the filter's rows (S,); NaN where there is nothing to see"""
    along_motion: bool = False
    """whether the equation is read with the sign of the motion: what rubs then stands on one side"""
    is_cyclic: bool = False
    """whether values are parts of a turn, from 0 to 1"""

    def motion_sign(self, recording: RecordingLinearisation, place: int) -> Array:
        """Sign with which a row is read, (S,); of filtered signals the sign of speed is not the filtered sign of speed."""
        s = recording.signals
        if not self.along_motion:
            return np.ones(len(s.low_pass.kept))
        rate = s.theta_d if self.equation == "motor" else s.alpha_d
        return s.low_pass(np.sign(rate[:, place]))


def _filtered(values: Callable[[RecordingLinearisation], Array]) -> Callable[[RecordingLinearisation, int], Array]:
    """Of signals (T, places) that are known in every row of the log."""
    return lambda recording, place: recording.signals.low_pass(values(recording)[:, place])


def _force_rate(recording: RecordingLinearisation) -> Array:
    return np.gradient(recording.signals.f, recording.signals.step, axis=0)


def _tension(recording: RecordingLinearisation, place: int) -> Array:
    return tensions(recording)[place]


def _tension_rate(recording: RecordingLinearisation, place: int) -> Array:
    return recording.signals.low_pass(np.gradient(recording.tension[:, place], recording.signals.step))


def _tension_beyond_recent(recording: RecordingLinearisation, place: int) -> Array:
    """Tension beyond its mean over the last tau seconds, which fades exponentially: tau as creep has it."""
    s, tension = recording.signals, recording.tension[:, place]
    decay = np.exp(-s.step / float(recording.values["tau"][0]))
    recent = lfilter([1 - decay], [1, -decay], tension, zi=decay * tension[:1])[0]
    return s.low_pass(tension - recent)


def _angle_since_reversal(recording: RecordingLinearisation, place: int) -> Array:
    """Angle that a motor has turned since it last turned round, rad."""
    s = recording.signals
    theta = s.theta[s.low_pass.kept, place]
    forward = s.theta_d[s.low_pass.kept, place] > 0
    turned = np.append(True, forward[1:] != forward[:-1])
    last = np.maximum.accumulate(np.where(turned, np.arange(len(theta)), 0))
    return np.abs(theta - theta[last])


def _travel_since_reversal(recording: RecordingLinearisation, place: int) -> Array:
    """Cable that a motor wound or gave since it last turned round, m; NaN where that is far behind it."""
    travel = float(recording.signals.arm.drum[place]) * _angle_since_reversal(recording, place)
    crossing = 2 * abs(float(recording.values["play"][place])) * float(recording.values["pb"][0])
    return np.where(travel <= _CROSSINGS_SHOWN * crossing, travel, np.nan)


def _bend_since_reversal(recording: RecordingLinearisation, place: int) -> Array:
    """The motor's angle since it last turned round, rad; NaN where its bristles have long bent."""
    angle, widths = _angle_since_reversal(recording, place), recording.values["wp"]
    return np.where(angle <= _BENDS_SHOWN * widths[place % len(widths)], angle, np.nan)


def _drum_turns(recording: RecordingLinearisation) -> Array:
    gears = [motor.R for motor in recording.hypothesis.neck.motors]
    return recording.signals.theta / gears / (2 * np.pi)


def _cable_rate_by_joints(recording: RecordingLinearisation) -> Array:
    """Rate at which the joints lengthen each cable's way, (T, M), m/s."""
    s = recording.signals
    return -np.einsum("tij,ti->tj", Z(s.arm, s.alpha), s.alpha_d)


def _lean(recording: RecordingLinearisation, place: int) -> Array:
    return recording.signals.low_pass(recording.signals.alpha.sum(axis=1))


MOTOR_SPEED = ShownBy("motor", "speed", "rad/s", _filtered(lambda r: r.signals.theta_d))
MOTOR_ACCELERATION = ShownBy("motor", "acceleration", "rad/s^2", _filtered(lambda r: r.signals.theta_dd))
FORCE = ShownBy("motor", "force", "N", _filtered(lambda r: r.signals.f))
FORCE_RATE = ShownBy("motor", "rate of the force", "N/s", _filtered(_force_rate))
TENSION = ShownBy("motor", "tension", "N", _tension)
TENSION_ALONG_MOTION = ShownBy("motor", "tension", "N", _tension, along_motion=True)
TENSION_RATE = ShownBy("motor", "rate of the tension", "N/s", _tension_rate)
TENSION_BEYOND_RECENT = ShownBy("motor", "tension beyond its recent mean", "N", _tension_beyond_recent)
ELONGATION = ShownBy("motor", "elongation that the camera sees", "m", _filtered(lambda r: r.signals.x + r.x0))
CABLE_RATE = ShownBy("motor", "rate of the cable by the joints", "m/s", _filtered(_cable_rate_by_joints))
REVERSALS = ShownBy("motor", "travel since the motor turned round", "m", _travel_since_reversal, along_motion=True)
BENDING = ShownBy("motor", "angle since the motor turned round", "rad", _bend_since_reversal, along_motion=True)
DRUM_TURNS = ShownBy("motor", "turns of the drum", "turns", _filtered(_drum_turns))
JOINT_ANGLE = ShownBy("joint", "angle of the joint", "rad", _filtered(lambda r: r.signals.alpha))
JOINT_SPEED = ShownBy("joint", "speed of the joint", "rad/s", _filtered(lambda r: r.signals.alpha_d))
LEAN = ShownBy("joint", "lean of the tip", "rad", _lean)
