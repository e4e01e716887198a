"""All numbers of the observer's filter, which Python and exported C share: noises, times, first covariance, the pose's error."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model, PoseModel, pose_machine
from mechanism.description import Neck
from mechanism.machine import Machine
from observation.pose_error import UNSEEN_X0_SIGMA_M, PoseError, pose_error, pose_model
from observation.state_layout import StateLayout, layout_of
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import indexed

Array = NDArray[np.float64]

FRICTION_TIME_S = 0.2
"""s, for which what friction's law does not say lasts (docs/thresholds.md)"""
POSE_TIME_S = 1.0
"""s, for which the pose's error lasts (docs/thresholds.md)"""
POSE_RATE_HZ = 0.8
"""at which the pose's error varies, for the sigma of rates (docs/thresholds.md)"""
LAG_SIGMA_S = 3e-4
"""s: what a calibration leaves of the camera's clock beside the cables' damping (docs/thresholds.md)"""
X0_DRIFT_M = 2e-6
"""m in a square root of a second, by which pre-elongations wander (docs/thresholds.md)"""
KNOWN_X0_SIGMA_M = 2e-6
"""m, beside the pose's error, of a pre-elongation that a recording told (docs/thresholds.md)"""
JOINT_NOISE = 1.5e-3
"""(rad/s^2)^2 s, of torques that nobody describes (docs/thresholds.md)"""
MOTOR_NOISE = 100.0
"""(rad/s^2)^2 s: where a motor turns round within a row its friction is known to a part of it only (docs/thresholds.md)"""
MEMORY_NOISE = 1e-3
"""share of a cable's memory bound, or N, in a square root of a second (docs/thresholds.md)"""
MIN_FRICTION_SIGMA_N = 0.3
"""N, of a motor's equation, however well it was fitted (docs/thresholds.md)"""
MIN_POSE_SIGMA_RAD = np.radians(0.002)
"""rad, of each angle, however well it was calibrated (docs/thresholds.md)"""
MAX_POSE_SIGMA_RAD = np.radians(5.0)
"""rad: where the model leaves more of an angle in the middle of its range it tells nothing (docs/thresholds.md)"""
COUNT_SIGMA = 1 / np.sqrt(12)
"""of a count: of what is rounded"""


@dataclass(frozen=True)
class FilterNumbers:
    """Of one arm and model."""

    layout: StateLayout
    machine: Machine
    theta_sigma: Array
    """(M,), rad"""
    noise: Array
    """(size,), density of each entry of the state, its unit squared in a second"""
    decay: Array
    """(size,), 1/s"""
    start: Array
    """(size,): x0, else zero"""
    start_sigma: Array
    """(size,), but for the angles, which follow from x0"""
    pose_error: PoseError
    pose_floor: Array
    """(N,), rad"""
    memory_bound: Array
    """(M S,)"""
    friction_sigma: Array
    """(M,), N"""


def filter_numbers(neck: Neck, model: Model) -> FilterNumbers:
    """Raises Refused where the model was not identified for this."""
    _check_identified(model)
    pose = pose_model(model, neck)
    _check_counts(pose, neck)
    model = model.model_copy(update={"pose": pose})
    machine = pose_machine(model, neck)
    layout = layout_of(machine)
    told = {number.index for number in pose.numbers if number.kind == "x0"}
    x0_sigma = np.array([KNOWN_X0_SIGMA_M if j + 1 in told else UNSEEN_X0_SIGMA_M for j in range(layout.M)])
    friction_sigma = np.maximum(np.array(pose.residual.motor_N), MIN_FRICTION_SIGMA_N)
    dry = np.broadcast_to(machine.values.get("fs", np.zeros(1)), (layout.M,))
    noise, decay, start, start_sigma = (np.zeros(layout.size) for _ in range(4))
    bound = np.tile(machine.bounds[1], layout.M)
    noise[layout.alpha_d], noise[layout.theta_d] = JOINT_NOISE, MOTOR_NOISE
    noise[layout.memory] = (MEMORY_NOISE * np.where(np.isfinite(bound), bound, 1.0)) ** 2
    noise[layout.x0] = X0_DRIFT_M**2
    noise[layout.friction_error] = 2 * friction_sigma**2 / FRICTION_TIME_S
    decay[layout.friction_error], decay[layout.pose_error] = 1 / FRICTION_TIME_S, 1 / POSE_TIME_S
    start[layout.x0] = machine.arm.x0
    start[layout.memory] = machine.memory_start.ravel() if layout.S else 0.0
    start_sigma[layout.alpha], start_sigma[layout.alpha_d] = 1e-4, 1e-2
    start_sigma[layout.theta], start_sigma[layout.theta_d] = neck.count_angles * COUNT_SIGMA, 1.0
    start_sigma[layout.memory] = np.where(np.isfinite(bound), bound / 2, 1.0)
    start_sigma[layout.x0] = x0_sigma
    # at rest friction holds any force up to its whole
    start_sigma[layout.friction_error] = np.hypot(friction_sigma, dry)
    try:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            error = pose_error(model, neck)
    except np.linalg.LinAlgError as failed:
        raise Refused("model", f"its numbers give no pose ({failed})", "make it anew with `xneck identify`") from failed
    floor = np.hypot(np.array(pose.residual.angle_rad), MIN_POSE_SIGMA_RAD)
    middle = np.sqrt(np.sum(error.at(error.middle, error.tension[0]) ** 2, axis=1))
    if np.any(middle > MAX_POSE_SIGMA_RAD):
        i = int(np.argmax(middle))
        raise Refused(
            "model",
            f"leaves {np.degrees(middle[i]):.1f} deg of alpha{i + 1} open",
            "identify it from a recording with a camera: `xneck identify` writes what motors need to tell the joints",
        )
    if not (np.isfinite(error.factor).all() and np.isfinite(start).all() and np.isfinite(start_sigma).all()):
        raise Refused(
            "model", "its numbers give no pose", "is it this arm's neck.yaml? make it anew with `xneck identify`"
        )
    start_sigma[layout.pose_error] = np.hypot(middle, floor)
    return FilterNumbers(
        layout=layout,
        machine=replace(machine, arm=replace(machine.arm, x0=np.zeros(layout.M))),
        theta_sigma=neck.count_angles * COUNT_SIGMA,
        noise=noise,
        decay=decay,
        start=start,
        start_sigma=start_sigma,
        pose_error=error,
        pose_floor=floor,
        memory_bound=bound,
        friction_sigma=friction_sigma,
    )


def _check_counts(pose: PoseModel, neck: Neck) -> None:
    """Refused where what was left is of another arm."""
    left = pose.residual
    if {len(v) for v in (left.angle_rad, left.low_alpha, left.high_alpha)} != {neck.N} or len(left.motor_N) != neck.M:
        raise Refused("model", f"pose: it is of another arm than one with {neck.N} joints and {neck.M} motors")


def _check_identified(model: Model) -> None:
    """Refused where nothing says how stiff a cable is."""
    if model.pose is not None:
        return
    unsure = [p for p in model.parameters if p.name in ("k", "E") and not p.identified]
    if unsure or not any(p.name in ("k", "E") for p in model.parameters):
        names = ", ".join(indexed(p.name, p.index) for p in unsure) or "k"
        raise Refused(
            "model",
            f"{names} was not identified, and without it motors do not tell where the joints are",
            "record a motion that tells it, with a camera, and run `xneck identify` again",
        )
