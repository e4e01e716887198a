"""Faults in words: records for the result, what to set right, and whether the data can be used as they are."""

from typing import Any

from synchronisation.check.exchanges import Exchange
from synchronisation.check.fault_search import NamedFault
from synchronisation.check.faults import FAULTS

SHOWN_UNITS = {"rad": (57.29578, "deg"), "1": (100.0, "%"), "m": (1e3, "mm"), "s": (1e3, "ms")}
"""factor and unit in which a size is shown to people, by the unit of the record"""


def fault_record(named: NamedFault) -> dict[str, Any]:
    """The contract's record of a fault; `or` lists what explains as much, with places and sizes."""
    best = named.best
    record = _record(best.candidate.fault, best.candidate.where, best.size, best.candidate.unit, best.sigma)
    names = dict.fromkeys(r.candidate.fault for r in named.rivals)
    record["indistinguishable_from"] = [name for name in names if name != best.candidate.fault]
    record["or"] = [
        {"fault": r.candidate.fault, "where": r.candidate.where, "size": r.size, "unit": r.candidate.unit}
        for r in named.rivals
    ]
    if best.candidate.when is not None:
        record["when_s"] = best.candidate.when
    return record


def exchange_record(exchange: Exchange) -> dict[str, Any]:
    """The record of an exchange: its size is the RMS residual of the elongations, its sigma the residual with it undone."""
    return _record(exchange.fault, exchange.where, exchange.rms_described, "m", exchange.rms_undone)


def clock_record(delay: float, sigma: float) -> dict[str, Any]:
    """The record of frames whose times are `delay` s later than true."""
    return _record("clock_offset", "all", delay, "s", sigma)


def unexplained_record(cable: int, rms: float, sigma: float) -> dict[str, Any]:
    """The record of an elongation of which nothing explains `rms`, m."""
    return _record("unexplained_elongation", f"cable {cable}", rms, "m", sigma)


def usable(faults: tuple[dict[str, Any], ...]) -> bool | str:
    """Whether a data set can be identified as it is: True, False, or `in part`."""
    if not faults:
        return True
    return "in part" if all(FAULTS[fault["fault"]].of_one_moment for fault in faults) else False


def sentence(fault: dict[str, Any]) -> str:
    """One fault, its size, what else it could be, and what to do."""
    factor, unit = SHOWN_UNITS.get(fault["unit"], (1.0, fault["unit"]))
    size = f"{factor * fault['size']:.3g} {unit} +- {factor * fault['sigma']:.2g}"
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
        "fix": FAULTS[name].fix,
    }
