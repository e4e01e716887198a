"""The model with its causes in it: neck.yaml and model.yaml, from which simulation and identification go on."""

from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from diagnosis.cause_fit import FitStage
from diagnosis.cause_parameters import known, parameters_of
from diagnosis.hypothesis import Hypothesis
from diagnosis.nuisances import adjusted
from identification.model_file import Model, model_of
from mechanism.description import Neck
from xneck_foundation.least_squares import Parameter

Array = NDArray[np.float64]


def model(turn: FitStage, h: Hypothesis, provenance: dict[str, Any]) -> Model:
    """Base laws and those of the causes, with their numbers; h: the hypothesis that holds the causes."""
    end, fit = turn.end, turn.fit
    u = end.point.unknowns
    value = end.point.p + u.size * fit.numbers[: len(u.size)]
    sigma = u.size * turn.sigma[: len(u.size)]
    found = [
        Parameter(e.term.name, e.index, float(v), e.term.unit, float(s), known(v, s))
        for e, v, s in zip(u.entries, value, sigma, strict=True)
        if e.recording is None
    ]
    named = {(p.name, p.index): p for own in parameters_of(turn) for p in own}
    for name, values in h.values.items():
        for i, v in enumerate(values):
            index = None if len(values) == 1 else i + 1
            found.append(named.get((name, index)) or Parameter(name, index, float(v), "", float("inf"), False))
    return model_of(found, u.laws, provenance)


def description(turn: FitStage, h: Hypothesis) -> Neck:
    """neck.yaml with what was found wrong in it, and with its numbers moved within what drawings are good for."""
    fit, end = turn.fit, turn.end
    names = end.known.names
    return _turned(adjusted(h.neck, names, fit.numbers[end.base : end.base + len(names)]), h.misread)


def _turned(neck: Neck, misread: Array) -> Neck:
    """With the markers of every bar turned by what its orientation was read too large; those on diagonals stay."""
    if neck.markers is None or not misread.any():
        return neck
    by_bar = np.append(0.0, np.cumsum(misread))
    markers = [
        m if m.bar is None else m.model_copy(update={"angle": m.angle + float(by_bar[m.bar])})
        for m in neck.markers.on_bars
    ]
    return neck.model_copy(update={"markers": neck.markers.model_copy(update={"on_bars": tuple(markers)})})


def neck_yaml(neck: Neck) -> str:
    """As a file."""
    return yaml.safe_dump(neck.model_dump(mode="json", exclude_none=True), sort_keys=False, allow_unicode=True)
