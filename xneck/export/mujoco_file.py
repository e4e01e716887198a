"""The arm with a model's laws as a file for MuJoCo, and where its joints stand in a pose."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from identification.model_file import Model, machine_of, read_model
from mechanism.arm import arm_of
from mechanism.description import Neck, read_neck
from mechanism.geometry import check_angles
from mechanism.mjcf.bodies import joint_coordinates
from mechanism.mjcf.document import STEP_S, mjcf
from xneck.recording.result_files import EXTENDED_MODEL, EXTENDED_NECK
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import note_inputs, provenance
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class ArmFiles:
    """The two files that describe an arm with its laws."""

    neck: Path
    model: Path


def arm_files(sources: Sequence[Path]) -> ArmFiles:
    """The files of a folder of `xneck diagnose`, or the two that are given. Raises Refused where they are neither."""
    if len(sources) == 2 and not any(source.is_dir() for source in sources):
        return ArmFiles(*sources)
    if len(sources) == 1 and sources[0].is_dir():
        files = ArmFiles(sources[0] / EXTENDED_NECK, sources[0] / EXTENDED_MODEL)
        for file in (files.neck, files.model):
            if not file.is_file():
                what = f"holds no {file.name}"
                raise Refused(sources[0], what, "give a folder of `xneck diagnose`, or NECK.yaml and MODEL.yaml")
        return files
    raise Refused(
        ", ".join(map(str, sources)),
        "is no arm with its laws",
        "give one folder of `xneck diagnose`, or NECK.yaml MODEL.yaml",
    )


def mujoco_model(neck: Neck, model: Model, timestep: float = STEP_S) -> str:
    """The arm with the model's laws as MJCF, the text that MuJoCo reads; `timestep`, s, is that of its simulation.

    Raises Refused where the model has a law that MuJoCo has no element for.

    >>> import xneck
    >>> text = xneck.mujoco_model(xneck.read_neck("samples/recording/neck.yaml"), xneck.read_model("model.yaml"))
    >>> text.splitlines()[0]
    '<mujoco model="xneck arm">'
    """
    return mjcf(machine_of(model, arm_of(neck)), timestep)


def mujoco_start(neck: Neck, alpha: ArrayLike, theta: ArrayLike | None = None) -> dict[str, float]:
    """Coordinates of all joints of `mujoco_model` at joint angles alpha (N,), rad, and motor angles theta (M,), rad, or zero.

    Raises Refused where an angle is beyond the mechanism's range, or their number is not the arm's.

    >>> import xneck
    >>> neck = xneck.read_neck("samples/recording/neck.yaml")
    >>> start = xneck.mujoco_start(neck, [0.2, -0.1, 0.0])
    >>> round(start["A1"] + start["bar1"], 9)  # alpha of the first joint
    0.2
    """
    arm = arm_of(neck)
    angles, motors = (
        np.asarray(alpha, dtype=float),
        np.zeros(arm.M) if theta is None else np.asarray(theta, dtype=float),
    )
    for name, values, count in (("alpha", angles, arm.N), ("theta", motors, arm.M)):
        if values.shape != (count,):
            raise Refused("mujoco_start", f"{name} has the shape {values.shape}, expected ({count},)")
    check_angles(arm, angles, "mujoco_start")
    hinges = joint_coordinates(arm, angles).tolist()
    start = {
        f"{name}{i + 1}": value
        for i, of in enumerate(hinges)
        for name, value in zip(("A", "bar", "B"), of, strict=True)
    }
    return start | {f"motor{j + 1}": float(value) for j, value in enumerate(arm.drum * motors)}


def write_mujoco_file(files: ArmFiles, path: Path, timestep: float = STEP_S) -> dict[str, Any]:
    """Writes the arm, whole or not at all, and returns what was written, ready for JSON."""
    inputs = note_inputs({"neck": files.neck, "model": files.model})
    neck, model = read_neck(files.neck), read_model(files.model)
    text = mujoco_model(neck, model, timestep)
    origin = provenance(inputs)
    write_text(path, text)
    return {
        "file": path.name,
        "format": "MJCF",
        "mechanisms": neck.N,
        "cables": neck.M,
        "laws": list(model.laws),
        "timestep_s": timestep,
        "provenance": origin,
    }
