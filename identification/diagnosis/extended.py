"""The model with its causes in it, as files: neck.yaml and model.yaml, from which simulation and identification go on."""

from typing import Any

import yaml

from identification.diagnosis.diagnose import Diagnosis
from identification.diagnosis.nuisances import adjusted
from identification.diagnosis.record import KNOWN, parameters_of
from identification.model import Model, model_of
from mechanism.description import Neck
from xneck.estimate import Parameter


def model(d: Diagnosis, provenance: dict[str, Any]) -> Model:
    """Base laws and those of the causes, with their numbers."""
    end, fit = d.search.last.end, d.search.last.fit
    u = end.point.unknowns
    value = end.point.p + u.size * fit.numbers[: len(u.size)]
    sigma = u.size * d.sigma[: len(u.size)]
    found = [
        Parameter(e.term.name, e.index, float(v), e.term.unit, float(s), bool(s <= KNOWN * abs(v)))
        for e, v, s in zip(u.entries, value, sigma, strict=True)
        if e.recording is None
    ]
    known = {(p.name, p.index): p for own in parameters_of(d) for p in own}
    for name, values in d.extended.values.items():
        for i, v in enumerate(values):
            index = None if len(values) == 1 else i + 1
            own = known.get((name, index)) or Parameter(name, index, float(v), "", float("inf"), False)
            found.append(own)
    return model_of(found, u.laws, provenance)


def description(d: Diagnosis) -> Neck:
    """neck.yaml with what was found wrong in it, and with its numbers moved within what drawings are good for."""
    fit, end = d.search.last.fit, d.search.last.end
    names = end.nuisances[: len(end.nuisances) - 2 * len(end.matrix)]
    return adjusted(d.extended.neck, names, fit.numbers[end.base : end.base + len(names)])


def neck_yaml(neck: Neck) -> str:
    """As a file."""
    return yaml.safe_dump(neck.model_dump(mode="json", exclude_none=True), sort_keys=False, allow_unicode=True)
