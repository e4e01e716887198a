"""Every fault that check can name: its own, and those that are effects of `xneck diagnose` too, which say the same of both."""

from diagnosis.check_fault import CheckFault
from diagnosis.effects import EFFECTS

EXCHANGES = ("theta_sign", "swapped_cables", "swapped_markers")
"""signs and orders that were mixed up: nothing else can be told before these are right"""
_OF_CHECK = {
    "diagonal_length": CheckFault(
        fix="measure the diagonal bars between their pins and correct L in neck.yaml",
        tolerance=2e-3,
        tolerance_with_baseline=2e-4,
    ),
    "bar_length": CheckFault(
        fix="measure the bars between their pins and correct b in neck.yaml",
        tolerance=2e-4,
        tolerance_with_baseline=5e-5,
    ),
    "angle_scale": CheckFault(
        fix="check the camera's calibration and that camera.yaml belongs to this video",
        tolerance=3e-3,
        tolerance_with_baseline=5e-4,
    ),
    "plane_tilt": CheckFault(
        fix="turn the camera square to the plane of motion, or check the camera's calibration",
        tolerance=3e-3,
        tolerance_with_baseline=5e-4,
    ),
    "missed_counts": CheckFault(
        fix="check the encoder's cable and its counting rate; the zero of theta is lost",
        tolerance=1e-4,
        tolerance_with_baseline=5e-5,
    ),
    "winch_slip": CheckFault(
        fix="fasten the rope on its drum; use the data before it, or cut there and treat the rest as another recording",
        tolerance=1e-4,
        tolerance_with_baseline=5e-5,
        of_one_moment=True,
    ),
    "theta_sign": CheckFault(fix="correct theta_sign of the motor in neck.yaml"),
    "swapped_cables": CheckFault(fix="correct the order of the log's columns, or the routes in neck.yaml"),
    "swapped_markers": CheckFault(fix="correct markers.on_bars in neck.yaml, or the order of the angles' columns"),
    "unexplained_elongation": CheckFault(
        fix="look at the report's elongations over time: none of the known faults explains them"
    ),
}
FAULTS = {e.name: e.check_fault for e in EFFECTS.values() if e.check_fault is not None} | _OF_CHECK
"""every fault by name, with the size up to which an arm counts as healthy (docs/thresholds.md)"""
