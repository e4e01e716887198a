"""Arms of other lengths and forces whose equations say the same of the same angles: gravity goes with the lengths, time stays."""

from dataclasses import replace
from typing import Any

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series
from identification.model_file import Model
from identification.unknowns import terms_of
from mechanism.description import Neck


def similar_neck(neck: Neck, length: float, force: float) -> Neck:
    """The description with so many times the lengths and forces."""
    units = {
        **dict.fromkeys(("L", "b", "r", "rd", "free_length", "length", "x0", "gravity", "com"), length),
        **dict.fromkeys(("inertia", "Ia"), force * length),
        **dict.fromkeys(("mass", "stiffness"), force / length),
        "section": length**2,
    }

    def of_similar(value: Any, factor: float = 1.0) -> Any:
        if isinstance(value, dict):
            return {k: each if k == "tolerance" else of_similar(each, units.get(k, 1.0)) for k, each in value.items()}
        if isinstance(value, tuple):
            return tuple(of_similar(each, factor) for each in value)
        return value * factor if isinstance(value, float) else value

    return Neck.model_validate(of_similar(neck.model_dump()))


def with_forces(log: Series, force: float) -> Series:
    """The log or state with so many times the forces."""
    is_force = {name: name[0] == "f" and name[1:].isdigit() for name in log.columns}
    return Series(log.time, {name: column * (force if is_force[name] else 1.0) for name, column in log.columns.items()})


def similar_data(data: DataSet, length: float, force: float) -> DataSet:
    """The data set of such an arm."""
    return replace(data, neck=similar_neck(data.neck, length, force), state=with_forces(data.state, force))


def stronger_model(model: Model, force: float) -> Model:
    """The model of an arm of the same size with so many times the forces."""
    units = {term.name: term.unit for term in terms_of(model.laws)}
    factors = [force if "N" in units.get(p.name, "") else 1.0 for p in model.parameters]
    parameters = tuple(
        p.model_copy(update={"value": p.value * k, "sigma": None if p.sigma is None else p.sigma * k})
        for p, k in zip(model.parameters, factors, strict=True)
    )
    covariance = model.covariance and _scaled(model.covariance, factors)
    pose = model.pose
    if pose is not None:
        of_pose = [force if n.kind == "law" and "N" in units[n.name] else 1.0 for n in pose.numbers]
        numbers = tuple(
            n.model_copy(update={"value": n.value * k, "sigma": n.sigma * k})
            for n, k in zip(pose.numbers, of_pose, strict=True)
        )
        residual = pose.residual.model_copy(update={"motor_N": tuple(force * left for left in pose.residual.motor_N)})
        pose = pose.model_copy(
            update={"numbers": numbers, "covariance": _scaled(pose.covariance, of_pose), "residual": residual}
        )
    return model.model_copy(update={"parameters": parameters, "covariance": covariance, "pose": pose})


def _scaled(covariance: Any, factors: list[float]) -> tuple[tuple[float | None, ...], ...]:
    rows = zip(covariance, factors, strict=True)
    return tuple(tuple(None if c is None else c * a * b for c, b in zip(row, factors, strict=True)) for row, a in rows)
