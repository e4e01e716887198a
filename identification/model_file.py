"""model.yaml: identified laws and parameters, as a simulation takes them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import Field, field_validator, model_validator

from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.friction import CM
from mechanism.laws import LAWS, is_law, law_named
from mechanism.laws.backlash import OPERATOR
from mechanism.laws.unlisted import UnlistedLaw
from mechanism.machine import Machine
from mechanism.toleranced_numbers import moved, toleranced_numbers
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.one_line import indexed, listed
from xneck_foundation.parameter import Parameter
from xneck_foundation.spelling import quoted, valid_words
from xneck_foundation.strict_yaml import Strict, read_yaml
from xneck_foundation.whole_file import write_text


class ModelParameter(Strict):
    """A parameter as identify's results give it."""

    name: str
    index: int | None
    value: float
    unit: str
    sigma: float | None
    relative_sigma_percent: float | None
    identified: bool


Finite = Annotated[float, Field(allow_inf_nan=False)]


class PoseNumber(Strict):
    """A number by which motors tell the joints: of a law or cable as it is, of the drawing a share to be added (rad of a tilt),
    of markers by how much the camera sees a joint's angle beside that of the bars, rad."""

    name: str
    index: int | None
    kind: Literal["drawing", "law", "x0", "markers"]
    value: Finite
    sigma: Annotated[float, Field(ge=0, allow_inf_nan=False)]


class PoseResidual(Strict):
    """What the camera saw that these numbers do not say."""

    angle_rad: tuple[Finite, ...]
    """of each joint, beyond the frames' own noise, rms"""
    motor_N: tuple[Finite, ...]
    """of each motor's equation, rms"""
    low_alpha: tuple[Finite, ...]
    """least angle that was seen of each joint, rad"""
    high_alpha: tuple[Finite, ...]
    slope: tuple[Finite, ...] | None = None
    """how much each joint's residual changes along a radian of the arm's motion, rms; None where it is not known"""
    rate_rad_s: tuple[Finite, ...] | None = None
    """how fast each joint's residual changes, rms; None where it is not known"""
    lasting_rad: tuple[Finite, ...] | None = None
    """the part of angle_rad that is the same seconds later, rms; None where it is not known"""
    seconds: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    """length of the recording, or of the longest: 0 where none told"""
    count_rad: tuple[Finite, ...] | None = None
    """in which steps each motor's angle was logged; None of an earlier version: as described"""


def arm_digest(neck: Neck) -> str:
    """Tells whether two descriptions are of the same arm: by all but its markers, tolerances and how its log is written."""
    arm = neck.model_dump(include={"gravity", "mechanisms", "cables"})
    motors = [motor.model_dump(include={"R", "rd", "Ia"}) for motor in neck.motors]
    # a file may hold fewer digits than what was written into it
    rounded = json.loads(json.dumps([arm, motors]), parse_float=lambda text: f"{float(text):.6g}")
    return sha256(json.dumps(rounded).encode()).hexdigest()[:16]


class PoseModel(Strict):
    """Numbers of arm and laws by which motors tell the joints (identification/pose_calibration.py), with their covariance."""

    numbers: tuple[PoseNumber, ...]
    covariance: tuple[tuple[Finite, ...], ...]
    """in the order of the numbers"""
    residual: PoseResidual
    arm: str | None = None
    """digest of the description that it was calibrated with (`arm_digest`); None of an earlier version"""

    @model_validator(mode="after")
    def _square(self) -> "PoseModel":
        rows = len(self.numbers)
        if [len(row) for row in self.covariance] != [rows] * rows:
            raise ValueError(f"covariance: expected {rows} rows of {rows} numbers, as many as numbers")
        return self


class Model(Strict):
    """The laws that one arm's motors, cables and joints obey, and their numbers."""

    xneck_model: Literal[1] = 1
    laws: tuple[str, ...]
    parameters: tuple[ModelParameter, ...]
    covariance: tuple[tuple[float | None, ...], ...] | None = None
    """covariance of the parameters, in their order and units; null where it is unknown"""
    covariance_as_described: tuple[tuple[float | None, ...], ...] | None = None
    """the same were every number of neck.yaml exact, as a simulation takes them; None where that is what `covariance` is"""
    pose: PoseModel | None = None
    """numbers by which motors tell the joints, for `xneck observe`; None where no camera was there to find them"""
    provenance: dict[str, Any] = Field(default_factory=dict)

    @field_validator("laws")
    @classmethod
    def _known(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if not is_law(name):
                raise ValueError(f"unknown law {quoted(name)}, {valid_words(name, LAWS)}")
        return names

    @model_validator(mode="after")
    def _square(self) -> "Model":
        rows = len(self.parameters)
        for name in ("covariance", "covariance_as_described"):
            given = getattr(self, name)
            if given is not None and [len(row) for row in given] != [rows] * rows:
                raise ValueError(f"{name}: expected {rows} rows of {rows} numbers, as many as parameters")
        return self

    def is_of_another_arm(self, neck: Neck) -> bool:
        """Whether it was calibrated with the description of another arm; unknown of a model without `pose`."""
        return self.pose is not None and self.pose.arm not in (None, arm_digest(neck))

    def with_(self, **values: float | Sequence[float]) -> "Model":
        """The model with other values of some parameters: one number for all cables or joints, or one for each.

        What was set is exact: it has no sigma, and nothing covaries with it; `pose` is dropped. Raises Refused where the model has
        no such parameter, or another number of it, and where a value is none, or none that its law can have.
        """
        entries, names = list(self.parameters), {p.name for p in self.parameters}
        fixed: list[int] = []
        for name, value in values.items():
            one_of("model", name, sorted(names), "parameter")
            places = [k for k, p in enumerate(entries) if p.name == name]
            if np.asarray(value).dtype.kind not in "fiu":
                raise Refused(
                    "model", f"{name}: {quoted(str(value))} is no number", "give a number for all, or one for each"
                )
            numbers = np.atleast_1d(np.asarray(value, dtype=float)).tolist()
            numbers = numbers * len(places) if np.ndim(value) == 0 else numbers
            if len(numbers) != len(places):
                raise Refused(
                    "model", f"{name}: {len(numbers)} values for {len(places)}", "give one for all, or one for each"
                )
            for k, number in zip(places, numbers, strict=True):
                if not np.isfinite(number):
                    raise Refused("model", f"{name}: {number} is no number")
                self._check_possible(name, number)
                fix = {"value": number, "sigma": None, "relative_sigma_percent": None, "identified": False}
                entries[k] = entries[k].model_copy(update=fix)
            fixed += places
        changed: dict[str, Any] = {
            name: given
            and tuple(
                tuple(0.0 if i in fixed or j in fixed else v for j, v in enumerate(row)) for i, row in enumerate(given)
            )
            for name, given in (
                ("covariance", self.covariance),
                ("covariance_as_described", self.covariance_as_described),
            )
        }
        changed["parameters"] = tuple(entries)
        if fixed:  # what motors tell of the joints was found with the numbers as they were
            changed["pose"] = None
        return self.model_copy(update=changed)

    def _check_possible(self, name: str, number: float) -> None:
        """Raises Refused where a simulation would not take a number as it is: below the range of its law.

        An estimate may be there by chance, and is taken at the limit then; what a person sets is a slip.
        """
        terms = {term.name: term for law in self.laws for term in law_named(law).terms}
        low = terms[name].low if name in terms else -np.inf
        if low > 0 >= number or (low >= 0 > number):
            what = f"{name} of {number:g} {terms[name].unit} cannot be"
            raise Refused("model", what, "give a number above 0" if low > 0 else "give 0 or more")


def model_of(
    parameters: Sequence[Parameter],
    laws: Sequence[str],
    provenance: dict[str, Any],
    covariance: np.ndarray | None = None,
    held: Mapping[str, float | np.ndarray] | None = None,
    covariance_as_described: np.ndarray | None = None,
) -> Model:
    """The model that a fit's parameters make; friction's transition, where it was not fitted, is Fasquelle's (48).

    covariance: (P, P) of the parameters in their order; covariance_as_described: the same were neck.yaml exact, where that differs.
    held: numbers of the laws that were given and not fitted, by name.
    """
    entries = [ModelParameter(**p.as_json()) for p in parameters]
    units = {term.name: term.unit for name in laws for term in law_named(name).terms}
    given = dict(held or {})
    if not any(p.name == "cm" for p in entries):
        given |= {"cm": CM}
        units |= {"cm": "s/rad"}
    entries += [
        ModelParameter(
            name=name,
            index=None if np.size(value) == 1 else index,
            value=float(number),
            unit=units[name],
            sigma=None,
            relative_sigma_percent=None,
            identified=False,
        )
        for name, value in given.items()
        for index, number in enumerate(np.atleast_1d(value), start=1)
    ]
    return Model(
        laws=tuple(laws),
        parameters=tuple(entries),
        covariance=_rows(covariance, len(entries)),
        covariance_as_described=_rows(covariance_as_described, len(entries)),
        provenance=provenance,
    )


def _rows(covariance: np.ndarray | None, count: int) -> tuple[tuple[float | None, ...], ...] | None:
    """Of `count` parameters, the first of which have the covariance, and those behind them none."""
    if covariance is None:
        return None
    whole = np.zeros((count, count))
    whole[: len(covariance), : len(covariance)] = covariance
    return tuple(tuple(float(v) if np.isfinite(v) else None for v in row) for row in whole)


def machine_of(model: Model, arm: Arm) -> Machine:
    """The arm with the model's laws, for the simulation, and its x0 where it has them. Terms that the model leaves out are zero.

    A parameter that was not identified may be estimated below its law's range, such as a negative damping that would feed energy
    in: then it is taken at the limit of that range. Raises Refused where a term is not given for each of its cables or joints, and
    where one by which a law divides is given and not above zero, or a law spans joints that the arm has not.
    """
    values: dict[str, np.ndarray] = {}
    for name in model.laws:
        law = law_named(name)
        if isinstance(law, UnlistedLaw) and law.variable.joints > arm.N:
            what = f"{name} is of {law.variable.joints} joints at least; the arm has {arm.N}"
            raise Refused("model", what, "is it this arm's neck.yaml?")
        for term in law.terms:
            given = _values(model, term.name, term.count(arm))
            if term.low > 0 and any(p.name == term.name for p in model.parameters) and np.min(given) <= 0:
                where = indexed(term.name, int(np.argmin(given)) + 1 if len(given) > 1 else None)
                what = f"{where} of {name} is {given.min():g}, and must be above zero"
                raise Refused("model", what, "give it as `xneck identify` writes it")
            values[term.name] = np.maximum(given, min(term.low, 0.0))
    if any(p.name == "x0" for p in model.parameters):
        arm = replace(arm, x0=_values(model, "x0", arm.M))
    return Machine(arm, model.laws, values)


def observing_machine(model: Model, arm: Arm) -> Machine:
    """The machine of a model where motors shall tell the joints, without what its `pose` says.

    A drum with play is at its flank as soon as its motor has turned by the play (OPERATOR). What `identify` and `diagnose` tell by
    joints that were smoothed between frames crosses over later.
    """
    machine = machine_of(model, arm)
    if machine.play_place is None:
        return machine
    return replace(machine, values={**machine.values, **OPERATOR})


def pose_machine(model: Model, neck: Neck, amounts: Mapping[int, float] | None = None) -> Machine:
    """The arm with the numbers by which its motors tell its joints; amounts: added to some, by their place in the model's `pose`.

    As the model and the description have it where no camera found such numbers.
    """
    machine = observing_machine(model, arm_of(neck))
    if model.pose is None:
        return machine
    by_name = {number.name: number for number in toleranced_numbers(neck)}
    values = {name: v.copy() for name, v in machine.values.items()}
    x0, drawing = machine.arm.x0.copy(), {}
    for place, number in enumerate(model.pose.numbers):
        value = number.value + (amounts or {}).get(place, 0.0)
        if number.kind == "drawing" and number.name in by_name:
            drawing[number.name] = value
        elif number.kind == "x0" and number.index is not None and number.index <= len(x0):
            x0[number.index - 1] = value
        elif number.kind == "law" and number.name in values and (number.index or 1) <= len(values[number.name]):
            values[number.name][(number.index or 1) - 1] = value
        elif number.kind == "markers" and number.index is not None and number.index <= neck.N:
            continue  # of what the camera sees, not of the arm
        else:
            raise Refused(
                "model",
                f"pose: {indexed(number.name, number.index)} is none of this arm's numbers",
                "is it this arm's neck.yaml?",
            )
    arm = arm_of(moved(neck, [by_name[name] for name in drawing], list(drawing.values())))
    return Machine(replace(arm, x0=x0), machine.names, values)


def marker_offsets(pose: PoseModel, joints: int) -> np.ndarray:
    """By how much the camera sees each joint's angle beside that of the bars, (joints,), rad; zero where no one asked."""
    out = np.zeros(joints)
    for number in pose.numbers:
        if number.kind == "markers" and number.index is not None:
            out[number.index - 1] = number.value
    return out


def unlisted_laws_of(model: Model) -> tuple[tuple[str, ...], dict[str, float]]:
    """Names of the model's laws that no catalogue lists, and their inner constants by name: how they act, not how much."""
    laws = [law for name in model.laws if isinstance(law := law_named(name), UnlistedLaw)]
    names = {term.name for law in laws for term in law.constant_terms}
    return tuple(law.name for law in laws), {p.name: p.value for p in model.parameters if p.name in names}


def covariance_of(model: Model) -> np.ndarray:
    """Covariance of the parameters, (P, P), infinite where unknown; diagonal by their sigmas where the model has none."""
    if model.covariance is not None:
        return _matrix(model.covariance)
    return np.diag([np.inf if p.sigma is None else p.sigma**2 for p in model.parameters])


def covariance_as_described_of(model: Model) -> np.ndarray:
    """The same were every number of the description exact."""
    given = model.covariance_as_described
    return covariance_of(model) if given is None else _matrix(given)


def _matrix(rows: Sequence[Sequence[float | None]]) -> np.ndarray:
    return np.array([[np.inf if v is None else v for v in row] for row in rows])


def _values(model: Model, name: str, count: int) -> np.ndarray:
    entries = [p for p in model.parameters if p.name == name]
    if not entries:
        return np.zeros(count)
    if len(entries) == 1 and entries[0].index is None:
        return np.full(count, entries[0].value)
    by_index = {p.index: p.value for p in entries}
    if set(by_index) != set(range(1, count + 1)):
        given = listed("all" if index is None else str(index) for index in by_index)
        raise Refused("model", f"{name} is given for {given}; the arm has {count} of it", "is it this arm's neck.yaml?")
    return np.array([by_index[j + 1] for j in range(count)])


def write_model(model: Model, path: str | Path) -> None:
    """`model` as YAML, whole or not at all.

    >>> import xneck
    >>> stiffer = xneck.read_model("model.yaml").with_(k=9000.0)  # N/m, of all cables
    >>> xneck.write_model(stiffer, "stiffer.yaml")
    """
    write_text(path, yaml.safe_dump(model.model_dump(mode="json"), sort_keys=False, allow_unicode=True))


def read_model(path: str | Path) -> Model:
    """model.yaml. Raises Refused with every fault.

    >>> import xneck
    >>> xneck.read_model("model.yaml").laws  # of `xneck identify monday.mcap --out model.yaml`
    ('dry_friction', 'viscous_friction', 'linear_cable')
    """
    return read_yaml(path, Model)
