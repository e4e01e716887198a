"""Faults in words: what to set right, and whether the data can be used as they are."""

from typing import Any

from synchronisation.check.exchanges import Exchange
from synchronisation.check.fault_search import NamedFault

FIX = {
    "marker_offset": "set right the angle of the marker in neck.yaml (markers.on_bars), or extract with --placement",
    "drum_radius": "measure the drum, rope included, and correct rd (or the gear R, or counts) in neck.yaml",
    "pulley_radius": "measure the pulley, half the rope included, and correct r in neck.yaml",
    "diagonal_length": "measure the diagonal bars between their pins and correct L in neck.yaml",
    "bar_length": "measure the bars between their pins and correct b in neck.yaml",
    "angle_scale": "check the camera's calibration and that camera.yaml belongs to this video",
    "plane_tilt": "turn the camera square to the plane of motion, or check the camera's calibration",
    "clock_offset": "synchronise again, if need be with a light that the controller switches",
    "missed_counts": "check the encoder's cable and its counting rate; the zero of theta is lost",
    "winch_slip": "fasten the rope on its drum; use the data before it, or cut there and treat the rest as another recording",
    "cable_slack": "raise the least tension; leave the time around it out",
    "theta_sign": "correct theta_sign of the motor in neck.yaml",
    "swapped_cables": "correct the order of the log's columns, or the routes in neck.yaml",
    "swapped_markers": "correct markers.on_bars in neck.yaml, or the order of the angles' columns",
    "unexplained_elongation": "look at the report's elongations over time: none of the known faults explains them",
}
EXCHANGES = ("theta_sign", "swapped_cables", "swapped_markers")
IN_PART = ("winch_slip", "cable_slack")
"""faults of one moment: the rest of the recording is good"""


def fault_of(named: NamedFault) -> dict[str, Any]:
    """The contract's record; `or` lists what explains as much, with places and sizes."""
    best = named.best
    out = _record(best.candidate.fault, best.candidate.where, best.size, best.candidate.unit, best.sigma)
    names = dict.fromkeys(r.candidate.fault for r in named.rivals)
    out["indistinguishable_from"] = [name for name in names if name != best.candidate.fault]
    out["or"] = [
        {"fault": r.candidate.fault, "where": r.candidate.where, "size": r.size, "unit": r.candidate.unit}
        for r in named.rivals
    ]
    if best.candidate.when is not None:
        out["when_s"] = best.candidate.when
    return out


def fault_of_exchange(found: Exchange) -> dict[str, Any]:
    """Its size is what no law explains of the elongations, its sigma what it would leave."""
    return _record(found.fault, found.where, found.described, "m", found.undone)


def fault_of_clock(late: float, sigma: float) -> dict[str, Any]:
    """Frames whose times are `late` s later than true."""
    return _record("clock_offset", "all", late, "s", sigma)


def unexplained(cable: int, left: float, sigma: float) -> dict[str, Any]:
    """RMS of an elongation that nothing explains, m."""
    return _record("unexplained_elongation", f"cable {cable}", left, "m", sigma)


def usable(faults: tuple[dict[str, Any], ...]) -> bool | str:
    """Whether a data set can be identified as it is: True, False, or `in part`."""
    if not faults:
        return True
    return "in part" if all(fault["fault"] in IN_PART for fault in faults) else False


def sentence(fault: dict[str, Any]) -> str:
    """One fault, its size, what else it could be, and what to do."""
    size = f"{fault['size']:.3g} {fault['unit']} +- {fault['sigma']:.2g}"
    if fault["unit"] == "rad":
        size = f"{57.29578 * fault['size']:.3g} deg +- {57.29578 * fault['sigma']:.2g}"
    elif fault["unit"] == "1":
        size = f"{100 * fault['size']:.3g} % +- {100 * fault['sigma']:.2g}"
    elif fault["unit"] == "m":
        size = f"{1e3 * fault['size']:.3g} mm +- {1e3 * fault['sigma']:.2g}"
    elif fault["unit"] == "s":
        size = f"{1e3 * fault['size']:.3g} ms +- {1e3 * fault['sigma']:.2g}"
    when = f" at {fault['when_s']:.2f} s" if "when_s" in fault else ""
    others = "".join(f", or {o['fault']} of {o['where']}" for o in fault.get("or", []))
    return f"{fault['fault']} of {fault['where']}{when}: {size}{others}; {fault['fix']}"


def _record(name: str, where: str, size: float, unit: str, sigma: float) -> dict[str, Any]:
    return {
        "fault": name,
        "where": where,
        "size": size,
        "unit": unit,
        "sigma": sigma,
        "indistinguishable_from": [],
        "fix": FIX[name],
    }
