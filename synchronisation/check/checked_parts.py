"""The check of a recording from those of its consecutive parts.

A fault of one moment counts wherever it is seen. A fault that is there all the time must be seen in at least half of the parts:
among sixty parts chance shows some in one or two. What fewer parts show stands in the record, and is no verdict.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from synchronisation.check.check import CableCheck, Check
from synchronisation.check.faults import FAULTS

MIN_SHARE_OF_PARTS = 0.5
"""share of the parts that must show a lasting fault (docs/thresholds.md)"""
OVERLAP_S = 3.0
"""s by which the parts of a data set reach into their neighbours: at its ends a slip cannot be told (docs/thresholds.md)"""
SAME_MOMENT_S = 1.0
"""s: faults of one moment that are no further apart are one, seen in two parts that overlap (docs/thresholds.md)"""


def merged_checks(parts: Sequence[Check]) -> Check:
    """One check of a recording; parts: in the order of time. That of a single part as it is."""
    if len(parts) == 1:
        return parts[0]
    lasting: dict[tuple[str, str], list[dict[str, Any]]] = {}
    momentary: list[dict[str, Any]] = []
    for part in parts:
        for fault in part.faults:
            if not FAULTS[fault["fault"]].of_one_moment:
                lasting.setdefault((fault["fault"], fault["where"]), []).append(fault)
            elif not any(_same_moment(fault, other) for other in momentary):
                momentary.append(fault)
    shown = [_typical(seen) | {"parts": len(seen), "of_parts": len(parts)} for seen in lasting.values()]
    enough = MIN_SHARE_OF_PARTS * len(parts)
    faults = [fault for fault in shown if fault["parts"] >= enough]
    return Check(
        cables=tuple(_merged_cable([part.cables[j] for part in parts]) for j in range(len(parts[0].cables))),
        faults=(*sorted(faults, key=lambda fault: -fault["parts"]), *momentary),
        with_baseline=parts[0].with_baseline,
        parts=len(parts),
        in_few_parts=tuple(fault for fault in shown if fault["parts"] < enough),
    )


def _same_moment(fault: dict[str, Any], other: dict[str, Any]) -> bool:
    same = (fault["fault"], fault["where"]) == (other["fault"], other["where"])
    return same and abs(fault.get("when_s", 0.0) - other.get("when_s", 0.0)) <= SAME_MOMENT_S


def _typical(seen: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The record with the middle size of those that several parts gave."""
    return sorted(seen, key=lambda fault: fault["size"])[len(seen) // 2]


def _merged_cable(parts: Sequence[CableCheck]) -> CableCheck:
    """One cable's figures: means and root mean squares over parts of equal length."""

    def rms(values: Sequence[float]) -> float:
        return float(np.sqrt(np.mean(np.square(values))))

    means = [part.elongation_mean for part in parts]
    sigma = np.array([part.compliance_sigma for part in parts])
    weight = np.where(np.isfinite(sigma) & (sigma > 0), 1 / np.square(np.where(sigma > 0, sigma, 1.0)), 0.0)
    total = float(weight.sum())
    compliance = np.array([part.compliance for part in parts])
    return replace(
        parts[0],
        elongation_mean=float(np.mean(means)),
        elongation_rms=float(np.hypot(rms([part.elongation_rms for part in parts]), np.std(means))),
        unexplained_rms=rms([part.unexplained_rms for part in parts]),
        expected_rms=rms([part.expected_rms for part in parts]),
        compliance=float(weight @ compliance / total) if total else float(np.mean(compliance)),
        compliance_sigma=total**-0.5 if total else float("inf"),
        offset=float(np.mean([part.offset for part in parts])),
    )
