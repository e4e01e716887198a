"""The whole arm with its laws as an MJCF document."""

from xml.etree.ElementTree import Comment, Element, indent, tostring

import numpy as np

from mechanism.machine import Machine
from mechanism.mjcf.bodies import write_bodies
from mechanism.mjcf.cables import write_cables
from mechanism.mjcf.elements import child
from mechanism.mjcf.law_elements import (
    refuse_unwritten,
    write_cable_forces,
    write_joint_forces,
    write_motor_forces,
    write_motor_friction,
)
from mechanism.mjcf.ramps import TOLERANCE
from xneck_foundation.errors import Refused

STEP_S = 2e-4
"""s: of the simulation in MuJoCo; its error is in proportion to it (docs/thresholds.md)"""


def mjcf(machine: Machine, step: float = STEP_S) -> str:
    """The arm with its laws as MJCF text; `step`, s, is what MuJoCo integrates with.

    Raises Refused where a law has no element in MuJoCo, with its name and the reason, and where a motor has no inertia or a cable
    no stiffness.
    """
    arm = machine.arm
    refuse_unwritten(machine.names)
    for j in np.flatnonzero(arm.motor_inertia <= 0):
        raise Refused("export to MJCF", f"motor {j + 1} has no inertia", "give its Ia in neck.yaml")
    root = Element("mujoco", model="xneck arm")
    root.append(Comment(_words(step)))
    child(root, "compiler", angle="radian", autolimits=False, inertiafromgeom=False)
    option = child(
        root,
        "option",
        timestep=step,
        gravity=(*map(float, arm.gravity), 0.0),
        integrator="implicitfast",
        solver="Newton",
        iterations=30,
        tolerance=1e-14,
        jacobian="dense",
    )
    child(option, "flag", contact="disable")
    default = child(root, "default")
    child(default, "joint", type="hinge", axis=(0, 0, 1))
    # MuJoCo closes loops by springs with a time constant: two steps is the shortest that it allows
    child(default, "equality", solref=(2 * step, 1), solimp=(0.9999, 0.9999, 0.001, 0.5, 2))
    child(child(default, "default", class_="pulley"), "geom", type="cylinder", rgba=(0.8, 0.6, 0.2, 0.4))
    worldbody, tendon, equality, actuator, sensor = (
        child(root, tag) for tag in ("worldbody", "tendon", "equality", "actuator", "sensor")
    )
    bodies = write_bodies(arm, worldbody, equality, tendon)
    angles = {f"alpha{i + 1}": _angle(tendon, i) for i in range(arm.N)}
    rest_lengths = write_cables(arm, bodies, worldbody, tendon)
    for j in range(arm.M):
        turned = child(tendon, "fixed", name=f"theta{j + 1}")
        child(turned, "joint", joint=f"motor{j + 1}", coef=float(1 / arm.drum[j]))
    write_motor_forces(machine, actuator)
    write_cable_forces(machine, rest_lengths, actuator)
    write_motor_friction(machine, {j.attrib["name"]: j for j in worldbody.iter("joint")}, actuator)
    write_joint_forces(machine, angles, actuator)
    for name in (*angles, *(f"theta{j + 1}" for j in range(arm.M))):
        child(sensor, "tendonpos", name=name, tendon=name)
    for j in range(arm.M):
        child(sensor, "tendonactuatorfrc", name=f"minus_tension{j + 1}", tendon=f"cable{j + 1}")
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def _angle(tendon: Element, i: int) -> Element:
    """alpha of a joint as a tendon: the sum of the hinges A and bar."""
    alpha = child(tendon, "fixed", name=f"alpha{i + 1}")
    for kind in ("A", "bar"):
        child(alpha, "joint", joint=f"{kind}{i + 1}", coef=1)
    return alpha


def _words(step: float) -> str:
    """What a person needs to use the file."""
    return f"""
An arm of X-joints. SI units and radians; x right, y up, z towards the viewer.

Controls: motor1..M, the motor forces at their cables as a log has them, N, held over a log's row. The other actuators are laws:
they follow lengths and speeds and take no control.
Sensors: alpha1..N, the joint angles, theta1..M, the motor angles on the motor's side, rad, and minus_tension1..M, N.
Coordinates: hinges A, bar and B of each mechanism (alpha = A + bar), all zero in the straight pose, and slides motor1..M (m of
cable wound in, (rd/R) theta). To begin in another pose set all of them: xneck.mujoco_start gives them.

cableJ is minus the tension: k x + ca x', never below zero. Its tendon has branches whose lengths add up to the pulley model's, up
to a constant that biasprm takes away. Functions of one variable (friction by an arc tangent, stiffening cables) are sums of ramps,
each an actuator with a limited force, {100 * TOLERANCE:g} % of the function off at most.
Loops are closed by MuJoCo's constraints, which are springs. What is wrong by them and by its integrator shrinks in proportion to
the timestep, {step:g} s here; the constraints' solref is two timesteps, so change both together.
"""
