"""Identified parameters for other tools: as arrays in a .mat file, and as the pre-elongations of a neck.yaml."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from identification.files.mat_file import write_mat_file
from mechanism.description import Neck
from mechanism.neck_text import neck_text
from xneck_foundation import strict_yaml
from xneck_foundation.errors import Refused
from xneck_foundation.parameter import Parameter
from xneck_foundation.whole_file import write_text


def write_mat(parameters: Sequence[Parameter], laws: Sequence[str], path: str | Path) -> None:
    """`parameters.k.value`, `.sigma`, `.identified`, columns in the order of cables or joints, and `.unit`; and `laws`."""
    names = dict.fromkeys(p.name for p in parameters)
    struct: dict[str, Any] = {}
    for name in names:
        of_name = [p for p in parameters if p.name == name]
        struct[name] = {
            "value": np.array([p.value for p in of_name]),
            "sigma": np.array([p.sigma for p in of_name]),
            "identified": np.array([p.identified for p in of_name]),
            "unit": of_name[0].unit,
        }
    content = {"parameters": struct, "laws": np.array(laws, dtype=object)}
    write_mat_file(content, path)


def write_neck(neck: Neck, parameters: Sequence[Parameter], source: str, path: str | Path) -> None:
    """neck.yaml with the pre-elongations that were identified, and all else as it was.

    Raises Refused where there are none, or one is beyond the range of a neck.yaml.
    """
    x0 = {p.index: p for p in parameters if p.name == "x0" and p.identified}
    if not x0:
        raise Refused(path, "no pre-elongation was identified", "give one data set: x0 is each recording's own")
    cables = tuple(
        cable.model_copy(update={"x0": x0[j].value}) if j in x0 else cable
        for j, cable in enumerate(neck.cables, start=1)
    )
    identified = ", ".join(f"{j} +- {1e3 * p.sigma:.2g} mm" for j, p in x0.items())
    text = neck_text(neck.model_copy(update={"cables": cables}), f"x0 as identified from {source}: cable {identified}")
    strict_yaml.validate_document(strict_yaml.parse_yaml(text, path), Neck, path)
    write_text(path, text)
