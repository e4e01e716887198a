"""The page's tables as rows of text; the template only lays them out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.camera import Camera
from calibration.estimation import Calibration
from calibration.lens import NAMES
from identification.dataset.clock_record import log_time
from identification.estimates import Estimates
from identification.fasquelle.method import WELL_IDENTIFIED, FasquelleFit
from identification.fasquelle.tables import rows
from mechanism.description import Neck
from xneck.recording.pipeline import Result
from xneck.report import published
from xneck.report.wording import number, percent, with_sigma

_PRINTED = {"Pa": ("GPa", 1e-9), "Pa s": ("MPa s", 1e-6), "1": ("", 1.0)}
"""units in which Fasquelle prints a table, and their factor"""


@dataclass(frozen=True)
class Cell:
    """A value with its relative sigma; one that is not identified is marked."""

    value: str
    relative: str = ""
    identified: bool = True


NOTHING = Cell("–")


@dataclass(frozen=True)
class FasquelleTable:
    """A table of Fasquelle: our columns, then those that it published (none where the arm has other cables)."""

    title: str
    columns: tuple[str, ...]
    reference: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[Cell, ...], tuple[Cell, ...]], ...]
    """label, unit, our cells, the published cells"""


def fasquelle_table(
    title: str, fits: Sequence[FasquelleFit], beside: Sequence[published.Column], cables: int
) -> FasquelleTable:
    """`fits` as columns, with `beside` as reference where it is of an arm with as many cables."""
    shown = tuple(beside) if cables == published.CABLES else ()
    out = []
    for label, unit, found in rows(list(fits)):
        printed, factor = _PRINTED.get(unit, (unit, 1.0))
        ours = tuple(
            Cell(number(factor * p.value), percent(p.relative_sigma_percent), p.identified) if p else NOTHING
            for p in found
        )
        theirs = tuple(_published(column.get(label)) for column in shown)
        out.append((label, printed, ours, theirs))
    titles = tuple(fit.title for fit in fits)
    return FasquelleTable(title, titles, titles if shown else (), tuple(out))


def estimate_rows(found: Estimates) -> list[tuple[str, str, str, str]]:
    """Parameter, value with sigma, unit, and whether it is identified: if not, why, and what would tell it."""
    out = []
    for p, verdict in found.judged:
        label = p.name if p.index is None else f"{p.name}({p.index})"
        unit, factor = _PRINTED.get(p.unit, (p.unit, 1.0))
        value = with_sigma(factor * p.value, factor * p.sigma) if np.isfinite(p.sigma) else number(factor * p.value)
        out.append((label, value, unit, "identified" if verdict.identified else f"no: {verdict.why}; {verdict.record}"))
    return out


def _published(pair: tuple[str, str] | None) -> Cell:
    if pair is None:
        return NOTHING
    return Cell(pair[0], f"{pair[1]} %", float(pair[1]) <= WELL_IDENTIFIED)


def cable_rows(neck: Neck) -> list[tuple[str, ...]]:
    """Cable, route, length, pre-elongation, gear, drum of every cable."""
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


def camera_rows(camera: Camera, calibration: Calibration | None) -> list[tuple[str, str, str]]:
    """Name, value with sigma, unit."""
    sigma = np.full(len(NAMES), np.nan) if camera.covariance is None else np.sqrt(np.diag(camera.covariance))
    out = []
    for name, value, s in zip(NAMES, camera.parameters.tolist(), sigma.tolist(), strict=True):
        fixed = calibration is not None and name not in calibration.free
        text = f"{number(value)} (held fixed)" if fixed else with_sigma(value, s) if s > 0 else number(value, 6)
        out.append((name, text, "px" if name in ("fx", "fy", "cx", "cy") else ""))
    return out


def picture_rows(calibration: Calibration) -> list[tuple[str, str, str, str]]:
    """Picture, error, held-out error, and why it was left out."""
    return [
        (
            picture.name,
            "–" if picture.rms_px is None else f"{picture.rms_px:.3f}",
            "–" if picture.held_out_rms_px is None else f"{picture.held_out_rms_px:.3f}",
            "used" if picture.used else f"left out: {picture.why}",
        )
        for picture in calibration.pictures
    ]


def check_rows(result: Result) -> list[tuple[str, ...]]:
    """The check's numbers of every cable."""
    return [
        (
            str(cable["cable"]),
            f"{number(1e3 * cable['elongation_mean'], 3)} ± {number(1e3 * cable['elongation_rms'], 3)}",
            number(1e3 * cable["unexplained_rms"], 2),
            number(1e3 * cable["expected_rms"], 2),
            with_sigma(1e3 * cable["compliance"], 1e3 * cable["compliance_sigma"]),
            number(1e3 * cable["offset"], 2),
        )
        for cable in result.data.check["cables"]
    ]


def fault_lines(result: Result) -> list[str]:
    """Each fault of the check in words."""
    out = []
    for fault in result.data.check["faults"]:
        size = f"{number(fault['size'], 3)} {fault['unit']} (σ {number(fault['sigma'], 2)})"
        others = fault["indistinguishable_from"]
        also = f"; could as well be {', '.join(others)}" if others else ""
        out.append(f"{fault['where']}: {fault['fault'].replace('_', ' ')}, {size}{also}")
    return out


def angle_rows(result: Result) -> list[tuple[str, ...]]:
    """Of every joint: range, frames without it, a frame's and the state's sigma, what separates them."""
    data, state = result.data, result.data.state
    time = log_time(data.clock, result.angles.time)
    smooth, sigma = np.degrees(state.matrix("alpha")), np.degrees(state.matrix("sigma_alpha"))
    inside = (time >= state.time[0]) & (time <= state.time[-1])
    out = []
    for i in range(data.neck.N):
        seen = np.degrees(result.angles.alpha[:, i])
        own = np.degrees(result.angles.sigma[:, i])
        away = (seen - np.interp(time, state.time, smooth[:, i]))[inside]
        out.append(
            (
                str(i + 1),
                f"{number(float(smooth[:, i].min()), 3)} to {number(float(smooth[:, i].max()), 3)}",
                str(int(np.isnan(seen).sum())),
                number(float(np.nanmedian(own)), 2),
                number(float(np.median(sigma[:, i])), 2),
                number(float(np.sqrt(np.nanmean(away**2))), 2),
            )
        )
    return out


def marker_rows(result: Result) -> list[tuple[str, str, str]]:
    """Marker, share of frames in which it was found, frames in which it was found twice."""
    if result.extraction is None:
        return []
    markers = result.extraction.angles.notes["markers"]
    return [(str(m["id"]), f"{100 * m['seen_share']:.1f} %", str(m["duplicates"])) for m in markers]


def simulated_rows(result: Result) -> list[tuple[str, str, str, str]]:
    """Each channel, its RMS, its noise floor and their unit: alpha in degrees, theta as cable travel."""
    if result.simulated is None:
        return []
    drum = result.data.arm.drum
    out = []
    for channel in result.simulated.channels:
        stem, index = channel.name.rstrip("0123456789"), int(channel.name[len(channel.name.rstrip("0123456789")) :])
        scale, unit = (np.degrees(1.0), "deg") if stem == "alpha" else (1e3 * float(drum[index - 1]), "mm of cable")
        rms, floor = number(scale * channel.rms, 3), number(scale * channel.noise_floor, 2)
        out.append((f"{stem} {index}", rms, floor, unit))
    return out
