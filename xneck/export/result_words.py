"""Every result that the face gives, in words for a person, and as a record ready for JSON."""

from functools import singledispatch
from typing import Any

import numpy as np

from diagnosis import record
from diagnosis.diagnose import Diagnosis
from discovery.discovery import Discovery
from identification import estimate_table
from identification.dataset.dataset import DataSet
from identification.estimates import Estimates
from identification.model_file import Model
from identification.simulation import channels
from identification.simulation.simulated_motion import SimulatedMotion
from identification.simulation.simulated_recording import SimulatedRecording
from mechanism.description import Neck
from mechanism.neck_text import neck_text
from observation import health
from observation.observed_log import ObservedLog
from synchronisation.check.check import Check
from synchronisation.wording import as_text as dataset_words
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import with_unit


def in_words(result: object) -> str:
    """A result for a person, a few lines: of data sets, checks, estimates, simulations, observed logs, diagnoses, found laws,
    models and arms.

    >>> import xneck
    >>> monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
    >>> print(xneck.in_words(xneck.check(monday)))  # doctest: +ELLIPSIS
    consistent
      cable 1: elongation ...
    >>> print(xneck.in_words(xneck.diagnose([monday], [tuesday])))  # doctest: +ELLIPSIS
    cause
      tip_payload (all): the arm carries something at its tip
        m = 0.0... +- 0.00... kg
        xm = ... m
        ym = ... m
      motor equations, not fitted: ...
    """
    return _words(result)


def as_record(result: object) -> dict[str, Any]:
    """A result as `--json` has it, ready for JSON.

    >>> import xneck
    >>> monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
    >>> xneck.as_record(xneck.check(monday))["verdict"]
    'consistent'
    >>> found = xneck.as_record(xneck.diagnose([monday], [tuesday]))
    >>> found["verdict"], [cause["effect"] for cause in found["causes"]]
    ('cause', ['tip_payload'])
    """
    return _record(result)


@singledispatch
def _words(result: Any) -> str:
    raise _no_result(result)


@singledispatch
def _record(result: Any) -> dict[str, Any]:
    raise _no_result(result)


def _no_result(result: object) -> Refused:
    return Refused("xneck", f"{type(result).__name__} is no result", "give what a function of xneck returned")


_words.register(Diagnosis, record.as_text)
_record.register(Diagnosis, record.as_json)
_words.register(Estimates, estimate_table.as_text)
_record.register(Estimates, Estimates.as_json)
_words.register(Check, Check.as_text)
_record.register(Check, Check.as_json)
_words.register(SimulatedMotion, SimulatedMotion.as_text)
_record.register(SimulatedMotion, SimulatedMotion.as_json)
_record.register(Discovery, Discovery.as_json)
_record.register(ObservedLog, ObservedLog.as_json)
_words.register(DataSet, dataset_words)


@_words.register
def _(result: Discovery) -> str:
    return result.words


@_words.register
def _(result: ObservedLog) -> str:
    rms = np.sqrt(np.mean(result.series.matrix("sigma_alpha") ** 2, axis=0))
    shown = ", ".join(f"{s:.3f}" for s in np.degrees(rms))
    sigma = f"{shown} deg rms" if np.isfinite(rms).all() else "unknown"
    arm = {"as identified": "as identified", "changed": "not as identified"}.get(
        health.verdict(result.health), "not judged"
    )
    head = f"{len(result.series)} rows, sigma of the joints {sigma}; the arm is {arm}"
    doubts = [] if result.doubt is None else [result.doubt]
    return "\n".join([head, *(f"  {line}" for line in (*health.sentences(result.health), *doubts))])


@_record.register
def _(result: DataSet) -> dict[str, Any]:
    return dict(result.clock)


@_words.register
def _(result: SimulatedRecording) -> str:
    return f"simulated less measured over windows of {result.window_s:.2f} s\n{channels.as_text(result.channels)}"


@_record.register
def _(result: SimulatedRecording) -> dict[str, Any]:
    return {
        "window_s": result.window_s,
        "from": result.source,
        "channels": [channel.as_json() for channel in result.channels],
        "rms": result.rms,
    }


@_words.register
def _(result: Model) -> str:
    lines = [", ".join(name.replace("_", " ") for name in result.laws)]
    for p in result.parameters:
        label = indexed(p.name, p.index)
        sigma = "" if p.sigma is None else f" +- {p.sigma:.2g}"
        number = with_unit(f"{p.value:.5g}{sigma}", p.unit)
        lines.append(f"  {label} = {number}{'' if p.identified else ', not identified'}")
    return "\n".join(lines)


@_record.register
def _(result: Model) -> dict[str, Any]:
    return result.model_dump(mode="json")


@_words.register
def _(result: Neck) -> str:
    return neck_text(result)


@_record.register
def _(result: Neck) -> dict[str, Any]:
    return result.model_dump(mode="json", exclude_none=True)
