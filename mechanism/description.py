"""neck.yaml: what the arm is made of, read strictly.

Every length, mass, stiffness is checked against the magnitude it can have in SI units, so that millimetres given for
metres are refused; all faults of a file are reported at once, each with its key's path.
"""

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from mechanism.neck_path import set_at
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.strict_yaml import Strict, read_yaml, validate_document

Length = Annotated[float, Field(ge=0.001, le=2.0)]
Angle = Annotated[float, Field(ge=-pi, le=pi)]
Word = Literal["right", "left", "right_through", "left_through", "strut", "strut_mirrored"]

SIDE_OF = {
    "right": "right",
    "right_through": "right",
    "strut": "right",
    "left": "left",
    "left_through": "left",
    "strut_mirrored": "left",
}


class Bar(Strict):
    """A diagonal bar: its mass and its inertia about its middle."""

    mass: Annotated[float, Field(ge=0, le=100)]
    inertia: Annotated[float, Field(ge=0, le=10)]


class Top(Strict):
    """The top bar of a mechanism; `com` in the bar's frame (x along the bar), inertia about that point."""

    mass: Annotated[float, Field(gt=0, le=100)]
    inertia: Annotated[float, Field(ge=0, le=10)]
    com: tuple[Annotated[float, Field(ge=-1, le=1)], Annotated[float, Field(ge=-1, le=1)]] = (0.0, 0.0)


class Spring(Strict):
    """One spring."""

    stiffness: Annotated[float, Field(ge=0, le=1e6)]
    free_length: Annotated[float, Field(ge=0, le=10)]


class Springs(Spring):
    """The two springs of a mechanism, one on each side, alike unless `right` says otherwise; with `slack` they cannot push."""

    slack: bool = False
    right: Spring | None = None
    """the spring on the right, where it is not as the one on the left"""

    @property
    def sides(self) -> tuple[Spring, Spring]:
        """The spring on the left and the one on the right."""
        return self, self.right or self


class Tolerance(Strict):
    """How well the numbers of the description are known, one standard deviation each; unless said as a workshop keeps them.

    Relative to the number, but for `tilt` and `marker_angle`, rad.
    """

    mass: Annotated[float, Field(ge=0, le=1)] = 0.03
    inertia: Annotated[float, Field(ge=0, le=1)] = 0.05
    motor_inertia: Annotated[float, Field(ge=0, le=1)] = 0.1
    stiffness: Annotated[float, Field(ge=0, le=1)] = 0.05
    """of every spring by itself"""
    free_length: Annotated[float, Field(ge=0, le=1)] = 0.01
    length: Annotated[float, Field(ge=0, le=1)] = 0.002
    """of L and b"""
    pulley: Annotated[float, Field(ge=0, le=1)] = 0.01
    drum: Annotated[float, Field(ge=0, le=1)] = 0.002
    tilt: Annotated[float, Field(ge=0, le=pi)] = 0.3 * pi / 180
    """of the base against gravity"""
    marker_angle: Annotated[float, Field(ge=0, le=pi)] = 0.3 * pi / 180
    """of the markers of one bar together against it, or of an angle's zero"""
    friction_curve: Annotated[float, Field(ge=0, le=1)] = 0.01
    """of dry friction: by how much its curve over speed may differ from the arc tangent (48)"""
    cable_strands: Annotated[float, Field(ge=0, le=100)] = 0.05
    """N: force by which strands that rub in a cable may lag behind its elongation"""


class Mechanism(Strict):
    """One X-joint: an antiparallelogram of two bars of length b and two diagonals of length L."""

    L: Length
    b: Length
    r: Annotated[float, Field(ge=0, le=0.5)]
    diagonal: Bar
    top: Top
    springs: Springs

    @model_validator(mode="after")
    def _pulleys_fit(self) -> "Mechanism":
        if self.b >= self.L:
            raise ValueError(f"L = {self.L} m must exceed b = {self.b} m for the diagonals to cross")
        if min(self.L, self.b) / 2 <= self.r:
            raise ValueError(f"pulleys of r = {self.r} m do not fit: L/2 and b/2 must exceed r")
        if (self.L**2 - self.b**2) ** 0.5 <= self.r:
            raise ValueError(f"pulleys of r = {self.r} m do not fit: the sides are too short even when straight")
        return self


class Cable(Strict):
    """A cable's way from the base up, its total length, section, and elongation x0 in the straight rest pose."""

    route: Annotated[tuple[Word, ...], Field(min_length=1)]
    length: Annotated[float, Field(ge=0.01, le=100)]
    section: Annotated[float, Field(ge=1e-9, le=1e-3)]
    x0: Annotated[float, Field(ge=-0.05, le=0.05)] = 0.0

    @model_validator(mode="after")
    def _route_holds(self) -> "Cable":
        for word in self.route[:-1]:
            if word in ("right", "left"):
                raise ValueError(f"'{word}' ends at its pulley, so it can only be the last of a route")
        for below, above in pairwise(self.route):
            if SIDE_OF[below] != SIDE_OF[above]:
                raise ValueError(
                    f"'{below}' leaves on the {SIDE_OF[below]} side, where '{above}' cannot take it up: "
                    f"words of one side are {', '.join(w for w, s in SIDE_OF.items() if s == SIDE_OF[below])}"
                )
        return self


class Motor(Strict):
    """A motor with its gear R, drum rd and rotor inertia Ia; the rest maps its encoder log into our convention."""

    R: Annotated[float, Field(ge=0.1, le=1e4)]
    rd: Annotated[float, Field(ge=1e-4, le=1)]
    Ia: Annotated[float, Field(ge=0, le=1)]
    counts: Annotated[int, Field(ge=1, le=2**31)]
    theta_sign: Literal[-1, 1] = 1
    fv: Annotated[float, Field(ge=0, le=10)] | None = None
    """viscous friction at the cable per motor speed, N s/rad, where it is known (from a run with the cables off, say)"""
    joint: str | None = None
    """its name in a JointState log, with its topic before it (/joint_states/motor1) where several have it; without one, motor j is
    the j-th joint"""
    theta_scale: Annotated[float, Field(gt=0)] = 1.0
    """rad on the motor side per unit in the log"""
    f_scale: float = 1.0
    """N on the cable per unit of effort in the log"""


WORKSHOP_DEPTH_SIGMA = 0.010
"""m: how far from the arm's plane a marker sits, where nobody measured it (docs/thresholds.md)"""
MEASURED_DEPTH_SIGMA = 0.001
"""m, of a depth that was measured without saying how well (docs/thresholds.md)"""


class BarMarker(Strict):
    """Where a marker sits: its middle `at` in its bar's frame, and its x axis' `angle` against the bar's.

    A bar may lie before or behind the arm's plane, and its marker with it (`depth`).

    Its bar is a horizontal one (`bar`: 0 is the base) or a diagonal one (`diagonal`: A2 is mechanism 2's from bottom left to
    top right, B2 the one from bottom right to top left). A bar's frame has its origin at the bar's middle and x along it,
    a diagonal's from its lower to its upper end.
    """

    id: Annotated[int, Field(ge=0, le=100_000)]
    bar: Annotated[int, Field(ge=0)] | None = None
    diagonal: Annotated[str, Field(pattern=r"^[AB][1-9][0-9]{0,2}$")] | None = None
    at: tuple[Annotated[float, Field(ge=-1, le=1)], Annotated[float, Field(ge=-1, le=1)]] = (0.0, 0.0)
    angle: Angle = 0.0
    depth: Annotated[float, Field(ge=-0.5, le=0.5)] | None = None
    """m from the arm's plane towards the camera, where it was measured"""
    depth_sigma: Annotated[float, Field(gt=0, le=0.5)] | None = None
    """m, of that measurement"""

    @property
    def depth_known(self) -> tuple[float, float]:
        """What is known of the depth before any recording: its value and standard deviation, m."""
        if self.depth is None:
            return 0.0, self.depth_sigma or WORKSHOP_DEPTH_SIGMA
        return self.depth, self.depth_sigma or MEASURED_DEPTH_SIGMA

    @model_validator(mode="after")
    def _one_bar(self) -> "BarMarker":
        if (self.bar is None) == (self.diagonal is None):
            found = "neither" if self.bar is None else f"bar: {self.bar} and diagonal: {self.diagonal}"
            raise ValueError(f"expected either `bar` or `diagonal`, found {found}")
        return self

    @property
    def mechanism(self) -> int | None:
        """Number of the mechanism, from 1, whose diagonal bar carries the marker; None on a horizontal bar."""
        return None if self.diagonal is None else int(self.diagonal[1:])

    @property
    def place(self) -> str:
        """The bar in words: `bar 1`, `diagonal A2`."""
        return f"bar {self.bar}" if self.diagonal is None else f"diagonal {self.diagonal}"


class Markers(Strict):
    """The printed markers: all of one dictionary and size (side of the black square)."""

    dictionary: str
    size: Annotated[float, Field(ge=0.002, le=1.0)]
    on_bars: Annotated[tuple[BarMarker, ...], Field(min_length=1, max_length=4096)]


class Neck(Strict):
    """The whole arm, as neck.yaml states it (contract; symbols are Fasquelle's)."""

    xneck: Literal[1]
    gravity: tuple[Annotated[float, Field(ge=-30, le=30)], Annotated[float, Field(ge=-30, le=30)]] = (0.0, -9.81)
    mechanisms: Annotated[tuple[Mechanism, ...], Field(min_length=1, max_length=100)]
    cables: Annotated[tuple[Cable, ...], Field(min_length=1, max_length=200)]
    motors: Annotated[tuple[Motor, ...], Field(min_length=1, max_length=200)]
    markers: Markers | None = None
    tolerance: Tolerance = Tolerance()

    @model_validator(mode="after")
    def _parts_agree(self) -> "Neck":
        faults = []
        n = len(self.mechanisms)
        if len(self.motors) != len(self.cables):
            faults.append(f"{len(self.motors)} motors for {len(self.cables)} cables: each cable needs one")
        beyond = self._beyond_the_last_mechanism()
        if len(beyond) == 1:
            faults += beyond
        elif beyond:
            faults.append(f"mechanisms: {n} are too few, in {len(beyond)} places: {beyond[0]}")
        named = [m.joint for m in self.motors if m.joint is not None]
        if named and (len(named) != len(self.motors) or len(set(named)) != len(named)):
            faults.append("motors[].joint: give every motor a name of its own, or none")
        ids = Counter(m.id for m in self.markers.on_bars) if self.markers else Counter[int]()
        repeated = [str(i) for i in sorted(ids) if ids[i] > 1]
        if repeated:
            faults.append(f"markers.on_bars: id {listed(repeated)} stands twice")
        if faults:
            raise ValueError("; ".join(faults))
        return self

    def _beyond_the_last_mechanism(self) -> list[str]:
        """All that needs more mechanisms than there are, in words: one number too small is one fault."""
        n = len(self.mechanisms)
        beyond = [
            f"cables[{j}].route crosses {len(cable.route)} mechanisms of {n}"
            for j, cable in enumerate(self.cables)
            if len(cable.route) > n
        ]
        for k, marker in enumerate(self.markers.on_bars if self.markers else ()):
            if marker.bar is not None and marker.bar > n:
                beyond.append(f"markers.on_bars[{k}].bar is {marker.bar}, but bars are 0..{n}")
            if marker.mechanism is not None and marker.mechanism > n:
                beyond.append(f"markers.on_bars[{k}].diagonal is {marker.diagonal}, but mechanisms are 1..{n}")
        return beyond

    def with_(self, changes: Mapping[str, Any]) -> "Neck":
        """The arm with other numbers, by their paths in neck.yaml: `mechanisms[0].L`; without a number, of all:
        `mechanisms.top.mass`.

        Raises Refused where there is no such key, or the arm would not be one.
        """
        tree = self.model_dump(exclude_unset=True)
        for path, value in changes.items():
            set_at(tree, path, np.asarray(value).tolist() if isinstance(value, np.generic | np.ndarray) else value)
        return validate_document(tree, Neck, "neck")

    @property
    def N(self) -> int:
        """Number of mechanisms."""
        return len(self.mechanisms)

    @property
    def M(self) -> int:
        """Number of cables and motors."""
        return len(self.cables)

    @property
    def count_angles(self) -> NDArray[np.float64]:
        """Angle of one encoder count of each motor, (M,), rad."""
        return np.array([2 * np.pi / motor.counts for motor in self.motors])


def read_neck(path: str | Path) -> Neck:
    """neck.yaml as a Neck. Raises Refused with every fault, its key's path, what was found and what is expected.

    >>> import xneck
    >>> neck = xneck.read_neck("samples/recording/neck.yaml")
    >>> heavier = neck.with_({"mechanisms[2].top.mass": 0.08, "gravity": [0.0, -9.81]})
    >>> neck.N, neck.M, heavier.mechanisms[2].top.mass
    (3, 4, 0.08)
    """
    return read_yaml(path, Neck, "all in SI units: m, kg, N, rad")


def markers_of(neck: Neck, where: str | Path) -> Markers:
    """The markers of the arm; Refused where neck.yaml has none."""
    if neck.markers is None:
        raise Refused(where, "has no `markers`", "say which markers sit on which bars, or give the angles as a CSV")
    return neck.markers
