"""The model with its causes in it: neck.yaml and model.yaml, from which simulation and identification go on."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from diagnosis.cause_parameters import identified, parameters_of
from diagnosis.fit_stage import FitStage
from identification.dataset.dataset import DataSet
from identification.model_file import Model, model_of
from mechanism.description import Neck
from mechanism.laws import law_named
from mechanism.printed_markers import Markers
from xneck_foundation.parameter import Parameter

Array = NDArray[np.float64]

_GAIN = "actuator_gain"
"""law by which forces of the log are off in proportion"""


def extended_model(stage: FitStage, provenance: dict[str, Any]) -> Model:
    """Base laws and those of the causes, with their numbers; and by how much the log's forces are off within a tolerance.

    Friction and stiffness are what they are beside these gains: without them, forces as logged would move the arm otherwise."""
    at, fit, h = stage.comparison.linearisation, stage.fit, stage.hypothesis
    u = at.unknowns
    value = at.p + u.size * fit.numbers[: len(u.size)]
    sigma = u.size * stage.sigma[: len(u.size)]
    parameters = [
        Parameter(
            name=e.term.name,
            index=e.index,
            value=float(v),
            unit=e.term.unit,
            sigma=float(s),
            identified=identified(v, s),
        )
        for e, v, s in zip(u.entries, value, sigma, strict=True)
        if e.recording is None
    ]
    column = {(e.term.name, e.index): place for place, e in enumerate(u.entries) if e.recording is None}
    numbers = [p for of_cause in parameters_of(stage) for p in of_cause]
    of_causes = {(p.name, p.index): p for p in numbers}
    first = stage.comparison.base_count + stage.comparison.nuisance_count
    column |= {(p.name, p.index): place for place, p in enumerate(numbers, first)}
    terms = {term.name: term for law in h.laws for term in law_named(law).terms}
    gains = _gains(stage)
    for name, values in h.values.items():
        if name == "g" and gains:
            continue
        for i, v in enumerate(values):
            index = None if terms[name].of == "arm" else i + 1
            unit = terms[name].unit
            unknown = Parameter(name=name, index=index, value=float(v), unit=unit, sigma=float("inf"), identified=False)
            parameters.append(of_causes.get((name, index), unknown))
    for place, gain in gains.items():
        column.setdefault((gain.name, gain.index), place)
        parameters.append(of_causes.get((gain.name, gain.index), gain))
    laws = u.laws if _GAIN in u.laws or not gains else (*u.laws, _GAIN)
    places = [column.get((p.name, p.index)) for p in parameters]
    sigmas = [p.sigma for p in parameters]
    of_fit = stage.comparison.covariance(stage.fit)
    covariance, as_described = (
        _covariance(c, stage.sigma, sigmas, places) for c in (of_fit, _as_adjusted(stage, of_fit))
    )
    return model_of(parameters, laws, provenance, covariance, covariance_as_described=as_described)


def _gains(stage: FitStage) -> dict[int, Parameter]:
    """By how much each motor's logged force is off the one that acts, within what drums are good for, by its column.

    None where forces are exact."""
    c, h = stage.comparison, stage.hypothesis
    motors, tolerance = h.arm.M, h.neck.tolerance.drum
    if tolerance == 0:
        return {}
    first = c.base_count + c.nuisances.count - motors
    columns = range(first, first + motors)
    named = 1 + h.values.get("g", np.zeros(motors))
    gain = 1 / (1 / named + tolerance * stage.fit.numbers[first : first + motors]) - 1
    sigma = tolerance * stage.sigma[first : first + motors]
    return {
        column: Parameter(name="g", index=j, value=float(g), unit="1", sigma=float(s), identified=identified(g, s))
        for j, (column, g, s) in enumerate(zip(columns, gain, sigma, strict=True), 1)
    }


def _as_adjusted(stage: FitStage, covariance: Array) -> Array:
    """Of a fit's numbers, (K, K), were those of the drawing and the markers where the fit moved them to: a Schur complement.

    A simulation runs on the arm as it was moved. What is not known of the drawing is made good for by laws and forces: these
    alone, off by all of that, would move the arm as no recording does."""
    first = stage.comparison.base_count
    held = slice(first, first + stage.comparison.nuisances.described_count)
    by_held = np.linalg.solve(covariance[held, held], covariance[held])
    return covariance - covariance[:, held] @ by_held


def _covariance(of_fit: Array, fit_sigma: Array, sigma: Sequence[float], places: Sequence[int | None]) -> Array:
    """Of numbers with these sigmas (P,), (P, P): as the fit's numbers in these places covary, of which `fit_sigma` are the sigmas.

    What has no place has no covariance with others."""
    told = [i for i, place in enumerate(places) if place is not None]
    rows = [place for place in places if place is not None]
    correlation = np.eye(len(sigma))
    correlation[np.ix_(told, told)] = (of_fit / np.outer(fit_sigma, fit_sigma))[np.ix_(rows, rows)]
    known = np.isfinite(sigma)
    finite = np.where(known, sigma, 0.0)
    covariance = np.outer(finite, finite) * correlation
    covariance[~known, ~known] = np.inf
    return covariance


def extended_description(stage: FitStage, recordings: Sequence[DataSet]) -> Neck:
    """neck.yaml with what was found wrong in it, and with its numbers moved within what drawings are good for.

    What these recordings' angles read too much is said of the markers where all were filmed, else of the angles' zeros, which
    `sync` takes off whatever they come from.
    """
    found = stage.adjusted(stage.hypothesis)
    if not found.angle_error.any():
        return found.neck
    if found.neck.markers is not None and all(data.is_filmed for data in recordings):
        return found.neck.model_copy(update={"markers": _turned(found.neck.markers, found.angle_error)})
    zero = found.neck.zero_angles + found.angle_error
    return found.neck.model_copy(update={"alpha_zero": tuple(zero.tolist())})


def _turned(markers: Markers, angle_error: Array) -> Markers:
    """Those of every bar turned by what its orientation was read too large; those on diagonals stay."""
    bar_error = np.append(0.0, np.cumsum(angle_error))
    on_bars = [
        m if m.bar is None else m.model_copy(update={"angle": m.angle + float(bar_error[m.bar])})
        for m in markers.on_bars
    ]
    return markers.model_copy(update={"on_bars": tuple(on_bars)})


def neck_yaml(neck: Neck) -> str:
    """The description as a file's text."""
    return yaml.safe_dump(neck.model_dump(mode="json", exclude_none=True), sort_keys=False, allow_unicode=True)
