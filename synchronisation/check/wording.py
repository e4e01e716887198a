"""Faults in words: what to set right, and whether the data can be used as they are."""

from typing import Any

from synchronisation.check.exchanges import Exchange
from synchronisation.check.fault_search import NamedFault
from synchronisation.check.faults import FAULTS


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
    return "in part" if all(FAULTS[fault["fault"]].of_one_moment for fault in faults) else False


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
        "fix": FAULTS[name].fix,
    }
