"""neck.yaml: what the arm is made of, read strictly.

Every length, mass, stiffness is checked against the magnitude it can have in SI units, so that millimetres given for
metres are refused; all faults of a file are reported at once, each with its key's path. The docstring of a key is what `xneck init`
writes beside it, and what editors show of the JSON schema: meaning, unit, how to measure it.
"""

from collections import Counter
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from mechanism.neck_path import set_at
from mechanism.printed_markers import Markers
from mechanism.tolerance import Tolerance
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import listed
from xneck_foundation.strict_yaml import Strict, read_yaml, validate_document

Length = Annotated[float, Field(ge=0.001, le=2.0)]
Word = Literal["right", "left", "right_through", "left_through", "strut", "strut_mirrored"]

SIDE_OF = {
    "right": "right",
    "right_through": "right",
    "strut": "right",
    "left": "left",
    "left_through": "left",
    "strut_mirrored": "left",
}


def _not_zero(value: float) -> float:
    if value == 0:
        raise ValueError("must not be 0, which makes every force nothing")
    return value


_SHOWN = 40
"""characters of places that are shown"""
LEAD_KG_M3 = 11340.0
"""kg/m^3: no part is denser in the mean"""
SOFTEST_N_M = 5.0
"""N/m: a softer spring gives way by a length of any mechanism under the weight of a bar; of those in N/mm few are stiffer"""
LONGEST_SPRING = 3.0
"""times L + b: as long as no side of a mechanism is, a spring without force would push in every pose"""
ANY_PART_KG = 0.01
"""kg that a part of the smallest arm may weigh, with axles and pulleys larger than itself"""


class Bar(Strict):
    """A diagonal bar, each of the two alike."""

    mass: Annotated[float, Field(ge=0, le=100)]
    """kg, of one diagonal bar with all that moves with it; by a scale"""
    inertia: Annotated[float, Field(ge=0, le=10)]
    """kg m^2, of one diagonal bar about its middle; mass L^2 / 12 for an even rod, else from CAD"""


class Top(Strict):
    """The top bar of a mechanism, which is the bottom bar of the next one."""

    mass: Annotated[float, Field(gt=0, le=100)]
    """kg, of the top bar with its pulleys, axles and markers; by a scale"""
    inertia: Annotated[float, Field(ge=0, le=10)]
    """kg m^2, of the top bar about its centre of mass; mass b^2 / 12 for an even rod, else from CAD"""
    com: tuple[Annotated[float, Field(ge=-1, le=1)], Annotated[float, Field(ge=-1, le=1)]] = (0.0, 0.0)
    """m, centre of mass of the top bar from its middle: along the bar to the right, and up; balance it on an edge, or from CAD"""


def _no_spring_in_n_mm(stiffness: float) -> float:
    if 0 < stiffness < SOFTEST_N_M:
        raise ValueError(f"{stiffness:g} N/m is softer than any spring that holds a bar: is it in N/mm?")
    return stiffness


class Spring(Strict):
    """One spring."""

    stiffness: Annotated[float, Field(ge=0, le=1e6), AfterValidator(_no_spring_in_n_mm)]
    """N/m, of each spring; hang two known weights on it: difference of force over difference of length"""
    free_length: Annotated[float, Field(ge=0, le=10)]
    """m, length of a spring from hook to hook without force; of one wound with pretension, where its line of force meets zero"""


class Springs(Spring):
    """The two springs of a mechanism, one on each side, alike unless `right` says otherwise."""

    slack: bool = False
    """true where springs hang loose when they are shorter than free_length, false where they push then"""
    right: Spring | None = None
    """the spring on the right, where it is not as the one on the left: {stiffness: ..., free_length: ...}"""

    @property
    def sides(self) -> tuple[Spring, Spring]:
        """The spring on the left and the one on the right."""
        return self, self.right or self


class Mechanism(Strict):
    """One X-joint: an antiparallelogram of two bars of length b and two diagonals of length L."""

    L: Length
    """m, length of the two diagonal bars from axle to axle; by a caliper"""
    b: Length
    """m, length of the bottom and of the top bar from axle to axle; by a caliper"""
    r: Annotated[float, Field(ge=0, le=0.5)]
    """m, radius of the pulleys on the bars' ends, to the middle of the cable: radius of the groove plus half the cable"""
    diagonal: Bar
    """each of the two diagonal bars"""
    top: Top
    """the top bar"""
    springs: Springs
    """the springs on the left and on the right, from the end of the bottom bar to that of the top bar"""

    @model_validator(mode="after")
    def _pulleys_fit(self) -> "Mechanism":
        if self.b >= self.L:
            raise ValueError(f"L = {self.L} m must exceed b = {self.b} m for the diagonals to cross")
        if min(self.L, self.b) / 2 <= self.r:
            raise ValueError(f"pulleys of r = {self.r} m do not fit: L/2 and b/2 must exceed r")
        if (self.L**2 - self.b**2) ** 0.5 <= self.r:
            raise ValueError(f"pulleys of r = {self.r} m do not fit: the sides are too short even when straight")
        return self

    @model_validator(mode="after")
    def _springs_fit(self) -> "Mechanism":
        longest = max(side.free_length for side in self.springs.sides)
        if longest > LONGEST_SPRING * (self.L + self.b):
            raise ValueError(
                f"springs.free_length of {longest:g} m is {longest / (self.L + self.b):.3g} times L + b = {self.L + self.b:.3g} m, "
                "which no side is longer than: is it in cm or mm?"
            )
        return self

    @model_validator(mode="after")
    def _bodies_are_possible(self) -> "Mechanism":
        most = max(LEAD_KG_M3 * self.L**3, ANY_PART_KG)
        for name, body in (("diagonal", self.diagonal), ("top", self.top)):
            if body.mass > most:
                raise ValueError(
                    f"{name}.mass of {body.mass:g} kg is more than a cube of lead as wide as L = {self.L:g} m: "
                    "is it in g?"
                )
            if body.inertia > body.mass * (self.L + self.b) ** 2:
                raise ValueError(
                    f"{name}.inertia of {body.inertia:g} kg m^2 is more than {body.mass:g} kg can have within "
                    f"L + b = {self.L + self.b:g} m: is it in kg mm^2 or g cm^2?"
                )
        return self


class Cable(Strict):
    """A cable, in the order of the motors."""

    route: Annotated[tuple[Word, ...], Field(min_length=1)]
    """one word for each mechanism that the cable goes through, from the base up: right, left (ends at the upper pulley of that
    side), right_through, left_through (goes on upwards on that side), strut, strut_mirrored (along the diagonal and back along
    the top bar, then upwards on the right, or mirrored on the left)"""
    length: Annotated[float, Field(ge=0.01, le=100)]
    """m, of the whole cable from the drum to its end, with the arm straight; by a tape"""
    section: Annotated[float, Field(ge=1e-9, le=1e-3)]
    """m^2, cross-section that carries load; pi d^2 / 4 of its diameter d, less for a rope with gaps; elastic models 2, 3 use it"""
    x0: Annotated[float, Field(ge=-0.05, le=0.05)] = 0.0
    """m, elongation of the cable when the arm stands straight at theta = 0; 0 where nobody knows: identify finds it"""

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
    """A motor with its gear and drum, and what its encoder log says."""

    R: Annotated[float, Field(ge=0.1, le=1e4)]
    """turns of the motor per turn of the drum; data sheet of the gear, 1 without a gear"""
    rd: Annotated[float, Field(ge=1e-4, le=1)]
    """m, radius of the drum to the middle of the cable; wind ten turns and measure: length / (20 pi)"""
    Ia: Annotated[float, Field(gt=0, le=1)]
    """kg m^2, inertia of all that turns with the motor's shaft, before the gear; data sheets of the rotor and of the gear"""
    counts: Annotated[int, Field(ge=1, le=2**31)]
    """steps of the encoder per turn of the motor, as they are counted (four for each line of a quadrature encoder)"""
    theta_sign: Literal[-1, 1] = 1
    """1 where theta grows as the cable is wound in, -1 where it grows as the cable is let out"""
    fv: Annotated[float, Field(ge=0, le=10)] | None = None
    """N s/rad, viscous friction at the cable per motor speed, where it is known; from a run with the cables off"""
    joint: str | None = None
    """name of the motor in a JointState log, with its topic before it (/joint_states/motor1) where several have it; without one,
    motor j is the j-th joint"""
    theta_column: Annotated[str, Field(min_length=1)] | None = None
    """column of a CSV or Parquet log with the motor's angle; without one, theta1 is that of motor 1, and so on"""
    f_column: Annotated[str, Field(min_length=1)] | None = None
    """column of a CSV or Parquet log with the force, as commanded; without one, f1 is that of motor 1, and so on"""
    theta_scale: Annotated[float, Field(gt=0)] = 1.0
    """rad of the motor per unit of the logged angle: 1 for rad, 0.0174533 for degrees, 6.28319 / counts for counts"""
    f_scale: Annotated[float, AfterValidator(_not_zero)] = 1.0
    """N on the cable per unit of the logged force: 1 for N, R / rd for N m of the motor"""


class LogFormat(Strict):
    """How a CSV or Parquet log is written, where not as `time,theta1..thetaM,f1..fM` in seconds, rad and N."""

    time_column: Annotated[str, Field(min_length=1)] = "time"
    """column with the time of each row"""
    time_scale: Annotated[float, Field(gt=0)] = 1.0
    """s per unit of that column: 1 for seconds, 0.001 for milliseconds, 1e-6 for microseconds, 1e-9 for nanoseconds"""
    nanoseconds_column: Annotated[str, Field(min_length=1)] | None = None
    """column with the nanoseconds that are added to it, where stamps are parted in two, as ROS parts them"""
    led_column: Annotated[str, Field(min_length=1)] = "led"
    """column that is 1 while the light is on that the video shows; may be missing in the log"""
    separator: Literal[",", ";", "\t", "|"] = ","
    """what stands between the columns of a CSV"""
    decimal: Literal[".", ","] = "."
    """what stands before the decimals of a CSV's numbers"""
    units_row: bool = False
    """true where the row below a CSV's header holds units instead of numbers: it is passed over"""

    @model_validator(mode="after")
    def _separators_differ(self) -> "LogFormat":
        if self.separator == self.decimal:
            raise ValueError("separator and decimal are both a comma: the file must tell columns from decimals")
        return self


class Neck(Strict):
    """The whole arm, as neck.yaml states it (contract; symbols are Fasquelle's)."""

    xneck: Literal[1]
    """version of this format"""
    gravity: tuple[Annotated[float, Field(ge=-30, le=30)], Annotated[float, Field(ge=-30, le=30)]] = (0.0, -9.81)
    """m/s^2, in the frame of the base bar: x to the right, y up; [0.0, -9.81] where the base is level and the arm stands on it"""
    mechanisms: Annotated[tuple[Mechanism, ...], Field(min_length=1, max_length=100)]
    """from the base up"""
    cables: Annotated[tuple[Cable, ...], Field(min_length=1, max_length=200)]
    """in the order of the motors"""
    motors: Annotated[tuple[Motor, ...], Field(min_length=1, max_length=200)]
    """one for each cable"""
    markers: Markers | None = None
    """the printed markers; leave it out where the joint angles come from elsewhere"""
    alpha_zero: tuple[Annotated[float, Field(ge=-0.5, le=0.5)], ...] | None = None
    """rad, what each joint angle reads while the joint stands straight: `sync` takes it off the angles that it is given. Leave it
    out where nobody knows: diagnose finds it"""
    log: LogFormat = LogFormat()
    """how the log is written, where its columns have other names than time,theta1..thetaM,f1..fM; `xneck logs FILE` says it"""
    tolerance: Tolerance = Tolerance()
    """how well these numbers are known, one standard deviation each; what is left out is known as a workshop keeps it"""

    @model_validator(mode="after")
    def _parts_agree(self) -> "Neck":
        faults = []
        n = len(self.mechanisms)
        if len(self.motors) != len(self.cables):
            faults.append(f"motors: {len(self.motors)} motors for {len(self.cables)} cables, and each cable needs one")
        if self.alpha_zero is not None and len(self.alpha_zero) != n:
            faults.append(f"alpha_zero: {len(self.alpha_zero)} angles for {n} mechanisms, and each has one")
        beyond = self._beyond_the_last_mechanism()
        if len(beyond) == 1:
            faults += beyond
        elif beyond:
            faults.append(f"mechanisms: {n} are too few, in {len(beyond)} places: {beyond[0]}")
        for key in ("joint", "theta_column", "f_column"):
            named = [name for motor in self.motors if (name := getattr(motor, key)) is not None]
            if named and (len(named) != len(self.motors) or len(set(named)) != len(named)):
                faults.append(f"motors[].{key}: give every motor a name of its own, or none")
        ids = [marker.id for marker in self.markers.on_bars] if self.markers else []
        for one in (one for one, count in sorted(Counter(ids).items()) if count > 1):
            places = listed((f"[{k}]" for k, other in enumerate(ids) if other == one), " and ", limit=_SHOWN)
            faults.append(f"markers.on_bars: id {one} stands twice, in {places}")
        faults += self._markers_upon_others()
        if faults:
            raise ValueError("; ".join(faults))
        return self

    def _markers_upon_others(self) -> list[str]:
        """Markers whose middles are where another's is, in words."""
        there: dict[tuple[str, tuple[float, float], float | None], int] = {}
        upon = []
        for k, marker in enumerate(self.markers.on_bars if self.markers else ()):
            first = there.setdefault((marker.place, marker.at, marker.depth), k)
            if first != k:
                upon.append(f"markers.on_bars[{k}] is at the same place of {marker.place} as [{first}]")
        return upon

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
        return validate_document(tree, Neck, "neck", written=False)

    @property
    def N(self) -> int:
        """Number of mechanisms."""
        return len(self.mechanisms)

    @property
    def M(self) -> int:
        """Number of cables and motors."""
        return len(self.cables)

    @property
    def zero_angles(self) -> NDArray[np.float64]:
        """What the joint angles read while the arm stands straight, (N,), rad."""
        return np.array(self.alpha_zero or np.zeros(self.N))

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
