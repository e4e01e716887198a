"""All numbers of the observer's filter, which Python and exported C share: noises, times, first covariance, the pose's error."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identification.model_file import Model, PoseModel, marker_offsets, pose_machine
from identification.pose_numbers import DRAGGED_SIGMA
from mechanism.description import Neck
from mechanism.machine import Machine
from mechanism.typical_load import typical_load
from observation.frame_correction import FrameCorrection, no_correction
from observation.pose_error import UNSEEN_X0_SIGMA_M, PoseError, pose_error, pose_model
from observation.pose_time import POSE_TIME_S
from observation.state_layout import StateLayout, layout_of
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import indexed

Array = NDArray[np.float64]

FRICTION_TIME_S = 0.2
"""s, for which what friction's law does not say lasts (docs/thresholds.md)"""
DRAGGED_TIME_S = 10.0
"""s, for which the share lasts that cables' dampers feel of motors that cross their play (docs/thresholds.md)"""
LET_GO_HZ = 0.8
"""at which friction in joints and on pulleys holds and lets go, for the sigma of rates (docs/thresholds.md)"""
X0_DRIFT_M = 2e-6
"""m in a square root of a second, by which pre-elongations wander at most, where calibration does not say less
(docs/thresholds.md)"""
MOTOR_NOISE_S = 1e-3
"""s, for which a motor's unmodelled force acts at once (docs/thresholds.md)"""
MEMORY_NOISE = 1e-3
"""share of a cable's memory bound, or N, in a square root of a second (docs/thresholds.md)"""
MIN_FRICTION_SHARE = 0.03
"""of the arm's typical load: sigma of a motor's equation at least, however well it was fitted (docs/thresholds.md)"""
MIN_POSE_SIGMA_RAD = np.radians(0.0002)
"""rad, of each angle, however well it was calibrated (docs/thresholds.md)"""
MAX_POSE_SIGMA_RAD = np.radians(5.0)
"""rad: where the model leaves more of an angle in the middle of its range it tells nothing (docs/thresholds.md)"""
COUNT_SIGMA = 1 / np.sqrt(12)
"""of a count: of what is rounded"""
START_ALPHA_RAD, START_ALPHA_D_RAD_S, START_THETA_D_RAD_S = 1e-3, 0.1, 50.0
"""sigmas where the observer begins: of motor speeds, and of what joints are off those that follow their motors: acceleration moves
them, and cables that stretch (docs/thresholds.md)"""


@dataclass(frozen=True)
class FilterNumbers:
    """The filter of one arm and model, in numbers; size: of StateLayout."""

    layout: StateLayout
    machine: Machine
    theta_sigma: Array
    """of counted motor angles, (M,), rad"""
    noise: Array
    """(size,), density of each entry of the state, its unit squared in a second"""
    decay: Array
    """(size,), 1/s"""
    start: Array
    """(size,): x0, else zero"""
    start_sigma: Array
    """(size,), but for the angles, which follow from others, and the pose's error, which follows from the pose"""
    marker_offset: Array
    """by how much the camera sees each joint's angle beside that of the bars, (N,), rad"""
    pose_error: PoseError
    pose_floor: Array
    """sigma of each joint's angle, however well it was calibrated, (N,), rad"""
    pose_slope: Array
    """sigma of how much the pose's error changes along a radian of motion, beside that of PoseError, (N,)"""
    pose_rate: Array
    """sigma of how fast the pose's error changes where joints turn, however slowly, (N,), rad/s"""
    no_correction: FrameCorrection
    """before any frame"""
    let_go_rate: float
    """1/s: how fast what friction holds of the angles changes; 0 where nothing holds them"""
    memory_bound: Array
    """largest magnitude of the cables' memory variables, (M S,), inf where there is none"""
    friction_sigma: Array
    """of the force that a motor's law does not say, (M,), N"""
    dry_friction: Array
    """all of each motor's dry friction, (M,), N; the arm's typical load where no law has any"""


def filter_numbers(neck: Neck, model: Model) -> FilterNumbers:
    """The filter's numbers for an arm with a model. Raises Refused where the model was not identified for this."""
    _check_identified(model)
    pose = pose_model(model, neck)
    _check_counts(pose, neck)
    model = model.model_copy(update={"pose": pose})
    machine = pose_machine(model, neck)
    layout = layout_of(machine)
    left_N = np.array(pose.residual.motor_N)
    friction_sigma = np.maximum(left_N, MIN_FRICTION_SHARE * typical_load(machine.arm))
    counts = pose.residual.count_rad
    theta_sigma = (neck.count_angles if counts is None else np.array(counts)) * COUNT_SIGMA
    bound = np.tile(machine.bounds[1], layout.M)
    has_bound = np.isfinite(bound)
    known_x0 = {number.index for number in pose.numbers if number.kind == "x0"}
    error = _checked_pose_error(model, neck)
    pose_floor = np.hypot(np.array(pose.residual.angle_rad), MIN_POSE_SIGMA_RAD)
    numbers = FilterNumbers(
        layout=layout,
        machine=replace(machine, arm=replace(machine.arm, x0=np.zeros(layout.M))),
        theta_sigma=theta_sigma,
        noise=layout.vector(
            theta_d=(left_N * machine.arm.drum / machine.arm.motor_inertia) ** 2 * MOTOR_NOISE_S,
            memory=(MEMORY_NOISE * np.where(has_bound, bound, 1.0)) ** 2,
            x0=_x0_drift(pose, error),
            dragged=2 * DRAGGED_SIGMA**2 / DRAGGED_TIME_S,
            friction_error=2 * friction_sigma**2 / FRICTION_TIME_S,
        ),
        decay=layout.vector(dragged=1 / DRAGGED_TIME_S, friction_error=1 / FRICTION_TIME_S, pose_error=1 / POSE_TIME_S),
        start=layout.vector(x0=machine.arm.x0, memory=machine.memory_start.ravel() if layout.S else 0.0),
        start_sigma=layout.vector(
            alpha=START_ALPHA_RAD,
            alpha_d=START_ALPHA_D_RAD_S,
            theta=theta_sigma,
            theta_d=START_THETA_D_RAD_S,
            memory=np.where(has_bound, bound / 2, 1.0),
            # the pose's error holds what is not known of those that a recording told
            x0=[0.0 if j + 1 in known_x0 else UNSEEN_X0_SIGMA_M for j in range(layout.M)],
            dragged=DRAGGED_SIGMA,
            # at rest friction holds any force up to its whole
            friction_error=np.hypot(friction_sigma, machine.values.get("fs", np.zeros(1))),
        ),
        marker_offset=marker_offsets(pose, layout.N),
        pose_error=error,
        pose_floor=pose_floor,
        pose_slope=np.zeros(layout.N) if pose.residual.slope is None else np.array(pose.residual.slope),
        pose_rate=np.zeros(layout.N) if pose.residual.rate_rad_s is None else np.array(pose.residual.rate_rad_s),
        no_correction=no_correction(error.middle, error.half_range, pose_floor, layout.M),
        let_go_rate=2 * np.pi * LET_GO_HZ * machine.holds_at_rest,
        memory_bound=bound,
        friction_sigma=friction_sigma,
        dry_friction=machine.values.get("fs", np.full(layout.M, typical_load(machine.arm))),
    )
    if not all(np.isfinite(v).all() for v in (error.factor, numbers.start, numbers.start_sigma)):
        raise _no_pose("")
    return numbers


def _x0_drift(pose: PoseModel, error: PoseError) -> float:
    """Density of each pre-elongation's wandering, m^2/s, by what lasts of what calibration left of the angles.

    Numbers that are fitted to T s of a random walk of density q leave q T / 6 of its variance."""
    left = pose.residual
    if not left.seconds:
        return X0_DRIFT_M**2
    lasts = np.hypot(left.angle_rad if left.lasting_rad is None else left.lasting_rad, MIN_POSE_SIGMA_RAD)
    by_x0 = float(np.sum(error.by_x0**2))
    return min(X0_DRIFT_M**2, 6 * float(np.sum(lasts**2)) / (left.seconds * max(by_x0, 1e-300)))


def _checked_pose_error(model: Model, neck: Neck) -> PoseError:
    """The pose's error of a model whose `pose` is known. Raises Refused where it says next to nothing of a joint."""
    try:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            error = pose_error(model, neck)
    except np.linalg.LinAlgError as failed:
        raise _no_pose(f" ({failed})") from failed
    if np.any(error.middle_sigma > MAX_POSE_SIGMA_RAD):
        i = int(np.argmax(error.middle_sigma))
        raise Refused(
            "model",
            f"leaves {np.degrees(error.middle_sigma[i]):.1f} deg of alpha{i + 1} open",
            "identify it from a recording with a camera: `xneck identify` writes what motors need to tell the joints",
        )
    return error


def _no_pose(why: str) -> Refused:
    do = "is it this arm's neck.yaml? make it anew with `xneck identify`"
    return Refused("model", f"its numbers give no pose{why}", do)


def _check_counts(pose: PoseModel, neck: Neck) -> None:
    """Refused where what was left is of another arm."""
    left = pose.residual
    told = [v for v in (left.slope, left.rate_rad_s, left.lasting_rad) if v]
    of_joints = (left.angle_rad, left.low_alpha, left.high_alpha, *told)
    of_motors = (left.motor_N, left.count_rad or left.motor_N)
    if {len(v) for v in of_joints} != {neck.N} or {len(v) for v in of_motors} != {neck.M}:
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
