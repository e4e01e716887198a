"""The arm as rigid bodies in MuJoCo: hinges up one diagonal of each mechanism, the other diagonal closing the loop.

Bar i-1 carries diagonal A (hinged at its left end), A carries bar i (at its right end), and diagonal B (hinged at the
right end of bar i-1) is held to the left end of bar i by an equality constraint. MuJoCo's constraints are springs with
a time constant, here two steps, the shortest it allows: the gap they leave shrinks with the square of the step.
"""

# mujoco comes without complete type stubs
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from samples.generator.linkage import solve

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Load:
    """What the real arm has and neck.yaml does not know; all zero: the arm as described."""

    payload_kg: float = 0.0
    """point mass on the middle of the tip bar"""
    base_tilt_rad: float = 0.0
    """the base's turn against the level, counter-clockwise positive: gravity leans the other way in the base frame"""
    spring_factor: float = 1.0
    """true spring stiffness over the described one"""


@dataclass(frozen=True)
class Energy:
    """J"""

    potential: float
    kinetic: float

    @property
    def total(self) -> float:
        """J"""
        return self.potential + self.kinetic


def _bar_body(top: dict[str, Any], payload: float) -> str:
    """Inertial element of a bar with a point mass on its middle: mass, centre and inertia of both together."""
    mass, (cx, cy) = top["mass"], top.get("com", [0.0, 0.0])
    total = mass + payload
    x, y = mass * cx / total, mass * cy / total
    inertia = top["inertia"] + (cx**2 + cy**2) * mass * payload / total
    return _inertial(total, x, y, inertia)


def _inertial(mass: float, x: float, y: float, inertia: float) -> str:
    # MuJoCo wants positive masses and inertias; only the turning about z ever takes part
    i, m = max(inertia, 1e-12), max(mass, 1e-12)
    return f'<inertial pos="{x!r} {y!r} 0" mass="{m!r}" diaginertia="{i!r} {i!r} {i!r}"/>'


def mjcf(neck: dict[str, Any], step: float, load: Load, integrator: str = "Euler") -> str:
    """The model as MJCF text; hinges turn about z, and at coordinate 0 a diagonal or a bar lies along its carrier."""
    mechanisms = neck["mechanisms"]
    g = (complex(*neck.get("gravity", [0.0, -9.81])) * np.exp(-1j * load.base_tilt_rad)).item()
    sites_of_base = _sites(0, None, mechanisms[0]["b"])
    body, closing = "", ""
    tendons, equalities = [], []
    for i, m in enumerate(mechanisms, start=1):
        L, b, d, s = m["L"], m["b"], m["diagonal"], m["springs"]
        next_b = mechanisms[i]["b"] if i < len(mechanisms) else None
        payload = load.payload_kg if i == len(mechanisms) else 0.0
        rod = _inertial(d["mass"], L / 2, 0.0, d["inertia"])
        body += f'<body name="A{i}" pos="{-b / 2!r} 0 0"><joint name="A{i}"/>{rod}'
        body += f'<body name="bar{i}" pos="{L - b / 2!r} 0 0"><joint name="bar{i}" pos="{b / 2!r} 0 0"/>'
        body += _bar_body(m["top"], payload) + _sites(i, b, next_b)
        # B hangs on bar i-1 beside A, so it is written after A and all that A carries are closed
        tail = f'<body name="B{i}" pos="{b / 2!r} 0 0"><joint name="B{i}"/>{rod}'
        closing = f'</body></body>{tail}<site name="end_B{i}" pos="{L!r} 0 0"/></body>' + closing
        equalities.append(f'<connect site1="end_B{i}" site2="top_left{i}"/>')
        rest = f"0 {s['free_length']!r}" if s.get("slack", False) else f"{s['free_length']!r}"
        for side in ("left", "right"):
            tendons.append(
                f'<spatial name="{side}{i}" stiffness="{load.spring_factor * s["stiffness"]!r}" springlength="{rest}">'
                f'<site site="bottom_{side}{i}"/><site site="top_{side}{i}"/></spatial>'
            )
    return f"""<mujoco>
  <option timestep="{step!r}" gravity="{g.real!r} {g.imag!r} 0" integrator="{integrator}" solver="Newton"
          iterations="20" tolerance="1e-14" jacobian="dense">
    <flag contact="disable" energy="enable"/>
  </option>
  <compiler autolimits="false" inertiafromgeom="false"/>
  <default>
    <joint type="hinge" axis="0 0 1"/>
    <equality solref="{2 * step!r} 1" solimp="0.9999 0.9999 0.001 0.5 2"/>
  </default>
  <worldbody>{sites_of_base}{body}{closing}</worldbody>
  <tendon>{"".join(tendons)}</tendon>
  <equality>{"".join(equalities)}</equality>
</mujoco>"""


def _sites(i: int, b_below: float | None, b_above: float | None) -> str:
    """Ends of bar i: as the top of mechanism i, and as the bottom of mechanism i + 1."""
    out = ""
    for side, sign in (("left", -0.5), ("right", 0.5)):
        if b_below is not None:
            out += f'<site name="top_{side}{i}" pos="{sign * b_below!r} 0 0"/>'
        if b_above is not None:
            out += f'<site name="bottom_{side}{i + 1}" pos="{sign * b_above!r} 0 0"/>'
    return out


class MujocoArm:
    """The arm in motion. Angles are of shape (N,), rad; torques on the joints of shape (N,), N m."""

    def __init__(self, neck: dict[str, Any], step: float, load: Load | None = None, integrator: str = "Euler") -> None:
        self.L = np.array([m["L"] for m in neck["mechanisms"]])
        self.b = np.array([m["b"] for m in neck["mechanisms"]])
        self.model = mujoco.MjModel.from_xml_string(mjcf(neck, step, load or Load(), integrator))
        self.data = mujoco.MjData(self.model)
        count = range(1, len(self.L) + 1)
        joint = {kind: [self.model.joint(f"{kind}{i}").id for i in count] for kind in ("A", "bar", "B")}
        self._A, self._bar, self._B = (np.array(joint[kind]) for kind in ("A", "bar", "B"))
        self._bodies = np.array([self.model.body(f"bar{i}").id for i in count])

    def place(self, alpha: Array) -> None:
        """At rest at joint angles alpha, with every loop closed."""
        bars = solve(np.asarray(alpha, dtype=float), self.L, self.b)
        below, above = np.exp(1j * bars.orientation[:-1]), np.exp(1j * bars.orientation[1:])
        A = bars.middle[1:] + self.b / 2 * above - (bars.middle[:-1] - self.b / 2 * below)
        B = bars.middle[1:] - self.b / 2 * above - (bars.middle[:-1] + self.b / 2 * below)
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self._A] = np.angle(A / below)
        self.data.qpos[self._B] = np.angle(B / below)
        self.data.qpos[self._bar] = np.asarray(alpha) - self.data.qpos[self._A]
        mujoco.mj_forward(self.model, self.data)

    @property
    def alpha(self) -> Array:
        """rad"""
        return self.data.qpos[self._A] + self.data.qpos[self._bar]

    @property
    def alpha_d(self) -> Array:
        """rad/s"""
        return self.data.qvel[self._A] + self.data.qvel[self._bar]

    @property
    def alpha_dd(self) -> Array:
        """rad/s^2, as of the last `step` (of the state before it)"""
        return self.data.qacc[self._A] + self.data.qacc[self._bar]

    @property
    def gap(self) -> float:
        """How far the loops are open, m: what MuJoCo's soft constraints leave."""
        ends = [
            self.data.site(f"end_B{i}").xpos - self.data.site(f"top_left{i}").xpos for i in range(1, len(self.L) + 1)
        ]
        return float(np.abs(ends).max())

    def energy(self) -> Energy:
        """At the pose and speed before the last `step` (or as placed)."""
        potential, kinetic = self.data.energy
        return Energy(float(potential), float(kinetic))

    def step(self, torque: Array) -> Array:
        """Accelerations alpha_dd, shape (N,), rad/s^2, that these torques make in the present state; then one step on.

        Torque i acts on bar i, its reaction on bar i-1: exact for cables, as each mechanism has one degree of freedom.
        """
        self.data.xfrc_applied[self._bodies, 5] = torque - np.append(torque[1:], 0.0)
        mujoco.mj_step(self.model, self.data)
        return self.alpha_dd
