"""What `xneck check` found of a recording, as its data set holds it, for whatever is estimated from it."""

from collections.abc import Mapping
from typing import Any

from identification.dataset.dataset import DataSet

_NOT_USABLE = {False: ", not usable as they are", "in part": ", usable in part"}
"""by the check's `usable`"""


def recorded_check(data: DataSet) -> dict[str, Any]:
    """Verdict, whether the data are usable, and the faults by name and place; of a data set that was not checked nulls."""
    faults = [{key: fault.get(key) for key in ("fault", "where")} for fault in data.check.get("faults", ())]
    return {"verdict": data.check.get("verdict"), "usable": data.check.get("usable"), "faults": faults}


def inconsistency(check: Mapping[str, Any]) -> str | None:
    """In words what a recorded check found; None where angles and motors agree, or nobody looked."""
    if check["verdict"] != "inconsistent":
        return None
    faults = ", ".join(f"{fault['fault']} of {fault['where']}" for fault in check["faults"])
    return f"inconsistent{_NOT_USABLE.get(check['usable'], '')} ({faults})"
