"""The check of a data set as its file holds it, made by `sync` or by hand."""

from dataclasses import replace

import numpy as np

from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from synchronisation.check.check import Baseline, Check, baseline_of, check_elongations, motors_in, not_healthy
from synchronisation.check.residual_clock import clock_left, mended
from synchronisation.check.faults import EXCHANGES
from xneck_foundation.errors import Refused


def check_dataset(data: DataSet, baseline: DataSet | None = None, where: str = "baseline") -> Check:
    """With `baseline`, a data set of the same arm that is known to be healthy; raises Refused where that one is not.

    Raises Refused where a data set holds no forces: then nothing says how far the cables stretch. Both are computed with
    the checked data set's neck.yaml. Where frames and log are found apart, that is the first fault, and others are those that are
    there once it is put right.

    >>> import xneck
    >>> found = xneck.check(xneck.read_dataset("monday.mcap"))
    >>> found.verdict, found.faults
    ('consistent', ())
    """
    for one, name in ((data, "check"), (baseline, where)):
        if one is not None and "f1" not in one.state.columns:
            raise Refused(name, "the data set holds no forces f", "log the force command of every motor")
    arm = data.arm
    fv = np.array([np.nan if motor.fv is None else motor.fv for motor in data.neck.motors])
    known: Baseline | None = None
    if baseline is not None:
        before = frame_angles(baseline)
        known = baseline_of(arm, baseline.state, before, _clock_sigma(baseline), where)
        late = clock_left(arm, before, motors_in(baseline.state), fv)
        if late is not None:
            raise not_healthy(where, late)
    seen = frame_angles(data)
    found = check_elongations(arm, data.state, seen, _clock_sigma(data), known)
    if found.faults and found.faults[0]["fault"] in EXCHANGES:
        return found
    late = clock_left(arm, seen, motors_in(data.state), fv)
    if late is None:
        return found
    rest = check_elongations(arm, data.state, mended(seen, late), late["sigma"], known)
    return replace(rest, faults=(late, *rest.faults))


def _clock_sigma(data: DataSet) -> float:
    return float(data.clock.get("offset_sigma_s") or 0.0)
