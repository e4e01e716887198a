"""model.yaml: what was identified, as simulation takes it up."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import Field

from mechanism.elasticity import Model as ElasticModel
from mechanism.friction import CM
from mechanism.simulation import Drive
from xneck.errors import Refused
from xneck.estimate import Parameter
from xneck.strict_yaml import Strict, read
from xneck.whole_file import write_text


class ModelParameter(Strict):
    """A parameter as identify's results give it."""

    name: str
    index: int | None
    value: float
    unit: str
    sigma: float | None
    relative_sigma_percent: float | None
    identified: bool


class Model(Strict):
    """Identified friction and elasticity of one arm."""

    xneck_model: Literal[1] = 1
    elastic_model: Literal[1, 2, 3]
    cm: Annotated[float, Field(gt=0)] = CM
    parameters: tuple[ModelParameter, ...]
    provenance: dict[str, Any] = Field(default_factory=dict)

    def values(self, name: str, cables: int) -> np.ndarray:
        """Values of a name for each cable, shape (cables,); one of a kind serves all, an absent one is zero."""
        found = [p for p in self.parameters if p.name == name]
        if not found:
            return np.zeros(cables)
        if len(found) == 1 and found[0].index is None:
            return np.full(cables, found[0].value)
        by_index = {p.index: p.value for p in found}
        if set(by_index) != set(range(1, cables + 1)):
            raise Refused("model", f"{name} is given for cables {sorted(map(str, by_index))}, the arm has {cables}")
        return np.array([by_index[j + 1] for j in range(cables)])


def model_of(parameters: Sequence[Parameter], elastic_model: ElasticModel, provenance: dict[str, Any]) -> Model:
    """The model that a fit's parameters make."""
    listed = tuple(ModelParameter(**p.as_json()) for p in parameters)
    content = {"elastic_model": elastic_model, "parameters": listed, "provenance": provenance}
    return Model.model_validate(content)


def drive_of(model: Model, cables: int) -> Drive:
    """Cables and motor friction for the simulation.

    A damping that was not identified and came out negative would feed energy in: it is taken as zero.
    """
    stiffness, damping = ("k", "ca") if model.elastic_model == 1 else ("E", "c")
    return Drive(
        stiffness=model.values(stiffness, cables),
        damping=np.maximum(model.values(damping, cables), 0.0),
        fs=model.values("fs", cables),
        fv=model.values("fv", cables),
        model=model.elastic_model,
        cm=model.cm,
    )


def write_model(model: Model, path: str | Path) -> None:
    """`model` as YAML, whole or not at all."""
    write_text(path, yaml.safe_dump(model.model_dump(mode="json"), sort_keys=False, allow_unicode=True))


def read_model(path: str | Path) -> Model:
    """model.yaml. Raises Refused with every fault."""
    return read(path, Model)
