"""The files of a recording, as the controller and a camera's evaluation would have left them."""

from pathlib import Path

import numpy as np
from mcap_ros2.writer import Writer

from samples.generator.taut_string import Array

# sensor_msgs/JointState of ROS 2 with what it is made of, comments left out
_JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def write_log_mcap(path: Path, log_time: Array, theta: Array, f: Array) -> None:
    """JointState messages on /joint_states; log_time of shape (T,), s; theta (rad) and f (N) of shape (T, M)."""
    names = [f"motor{j}" for j in range(1, theta.shape[1] + 1)]
    with path.open("wb") as stream, Writer(stream) as writer:
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", _JOINT_STATE)
        rows = zip(np.round(log_time * 1e9).astype(np.int64).tolist(), theta.tolist(), f.tolist(), strict=True)
        for sequence, (ns, position, effort) in enumerate(rows):
            sec, nanosec = divmod(ns, 1_000_000_000)
            header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""}
            message = {"header": header, "name": names, "position": position, "velocity": [], "effort": effort}
            writer.write_message("/joint_states", schema, message, log_time=ns, publish_time=ns, sequence=sequence)


def write_log_csv(path: Path, log_time: Array, theta: Array, f: Array) -> None:
    """The same as text; the digits keep encoder counts, the drive's steps and the clock's milliseconds apart."""
    m = theta.shape[1]
    header = ["time", *(f"theta{j}" for j in range(1, m + 1)), *(f"f{j}" for j in range(1, m + 1))]
    _write(path, header, [(log_time[:, None], "%.3f"), (theta, "%.4f"), (f, "%.3f")])


def write_angles_csv(path: Path, camera_time: Array, alpha: Array, sigma: Array) -> None:
    """Angles of a camera of one's own; camera_time of shape (F,), s; alpha, sigma of shape (F, N), rad."""
    n = alpha.shape[1]
    header = ["time", *(f"alpha{i}" for i in range(1, n + 1)), *(f"sigma{i}" for i in range(1, n + 1))]
    _write(path, header, [(camera_time[:, None], "%.6f"), (alpha, "%.6f"), (sigma, "%.6f")])


def _write(path: Path, header: list[str], blocks: list[tuple[Array, str]]) -> None:
    formats = [form for block, form in blocks for _ in range(block.shape[1])]
    rows = np.hstack([block for block, _ in blocks]) + 0.0  # no negative zeros
    np.savetxt(path, rows, fmt=formats, delimiter=",", header=",".join(header), comments="")
