"""The tables of a recording's page as rows of text."""

import numpy as np

from identification.dataset.clock_record import log_time
from identification.estimates import Estimates
from mechanism.description import Neck
from synchronisation.check.wording import SHOWN_UNITS
from xneck.recording.recording_result import RecordingResult
from xneck.report.fasquelle_table import PRINTED_UNITS
from xneck.report.number_text import number_text, with_sigma
from xneck_foundation.one_line import indexed
from xneck_foundation.unit_text import printed_unit


def estimate_rows(estimates: Estimates) -> list[tuple[str, str, str, str]]:
    """Rows of the table of estimates: parameter, value with sigma, unit, identified or why not and what would help."""
    rows = []
    for p, verdict in estimates.with_identifiability:
        label = indexed(p.name, p.index)
        unit, factor = PRINTED_UNITS.get(p.unit, (printed_unit(p.unit), 1.0))
        value = (
            with_sigma(factor * p.value, factor * p.sigma) if np.isfinite(p.sigma) else number_text(factor * p.value)
        )
        rows.append(
            (label, value, unit, "identified" if verdict.identified else f"no: {verdict.why}; {verdict.record}")
        )
    return rows


def cable_rows(neck: Neck) -> list[tuple[str, ...]]:
    """Rows of the table of cables: number, route, length, pre-elongation, gear, drum radius."""
    return [
        (
            str(j + 1),
            " → ".join(word.replace("_", " ") for word in cable.route),
            f"{cable.length:g} m",
            f"{1e3 * cable.x0:g} mm",
            f"{motor.R:g}",
            f"{1e3 * motor.rd:g} mm",
        )
        for j, (cable, motor) in enumerate(zip(neck.cables, neck.motors, strict=True))
    ]


def check_rows(result: RecordingResult) -> list[tuple[str, ...]]:
    """Rows of the table of the check, one a cable: elongation, what is unexplained and expected of it, compliance, offset."""
    return [
        (
            str(cable["cable"]),
            f"{number_text(1e3 * cable['elongation_mean'], 3)} ± {number_text(1e3 * cable['elongation_rms'], 3)}",
            number_text(1e3 * cable["unexplained_rms"], 2),
            number_text(1e3 * cable["expected_rms"], 2),
            with_sigma(1e3 * cable["compliance"], 1e3 * cable["compliance_sigma"]),
            number_text(1e3 * cable["offset"], 2),
        )
        for cable in result.data.check["cables"]
    ]


def fault_lines(result: RecordingResult) -> list[str]:
    """One line of text for each fault that the check found."""
    lines = []
    for fault in result.data.check["faults"]:
        factor, unit = SHOWN_UNITS.get(fault["unit"], (1.0, fault["unit"]))
        size = f"{number_text(factor * fault['size'], 3)} {unit} (σ {number_text(factor * fault['sigma'], 2)})"
        others = fault["indistinguishable_from"]
        also = f"; could as well be {', '.join(others)}" if others else ""
        lines.append(f"{fault['where']}: {fault['fault'].replace('_', ' ')}, {size}{also}")
    return lines


def angle_rows(result: RecordingResult) -> list[tuple[str, ...]]:
    """Rows of the table of joints: number, range, frames without it, sigma of a frame and of the state, RMS between the two."""
    data, state = result.data, result.data.state
    time = log_time(data.clock, result.angles.time)
    smooth, sigma = np.degrees(state.matrix("alpha")), np.degrees(state.matrix("sigma_alpha"))
    inside = (time >= state.time[0]) & (time <= state.time[-1])
    rows = []
    for i in range(data.neck.N):
        frames = np.degrees(result.angles.alpha[:, i])
        frame_sigma = np.degrees(result.angles.sigma[:, i])
        residual = (frames - np.interp(time, state.time, smooth[:, i]))[inside]
        rows.append(
            (
                str(i + 1),
                f"{number_text(float(smooth[:, i].min()), 3)} to {number_text(float(smooth[:, i].max()), 3)}",
                str(int(np.isnan(frames).sum())),
                number_text(float(np.nanmedian(frame_sigma)), 2),
                number_text(float(np.median(sigma[:, i])), 2),
                number_text(float(np.sqrt(np.nanmean(residual**2))), 2),
            )
        )
    return rows


def simulated_rows(result: RecordingResult) -> list[tuple[str, ...]]:
    """Rows of the table of the simulation: channel, unit, RMS, noise floor, their ratio, and what a true model stays below.

    alpha in degrees, theta as cable travel."""
    if result.simulated is None:
        return []
    drum = result.data.arm.drum
    rows = []
    for channel in result.simulated.channels:
        stem, index = channel.name.rstrip("0123456789"), int(channel.name[len(channel.name.rstrip("0123456789")) :])
        scale, unit = (np.degrees(1.0), "deg") if stem == "alpha" else (1e3 * float(drum[index - 1]), "mm of cable")
        rms, floor = number_text(scale * channel.rms, 3), number_text(scale * channel.noise_floor, 2)
        ratio, below = number_text(channel.ratio, 3), number_text(channel.ratio_95, 2)
        rows.append((f"{stem} {index}", unit, rms, floor, ratio, below))
    return rows
