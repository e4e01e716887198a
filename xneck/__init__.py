"""What all parts of xneck stand on: errors, strict files, whole outputs, estimates; and the way in from Python.

Functions are named after the commands and do what these do, without files of their own. They live in the packages above this
one and are fetched when they are first asked for, so that `import xneck` costs nothing and the command line stays quick.

>>> import xneck
>>> monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
>>> xneck.diagnose([monday], [tuesday]).verdict
'cause'
"""

import importlib
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from xneck.errors import Refused

if TYPE_CHECKING:
    from identification.dataset_file import read_dataset, write_dataset
    from identification.diagnosis.diagnose import diagnose
    from identification.diagnosis.record import as_json as as_record
    from identification.diagnosis.record import as_text as in_words
    from identification.estimates import estimate as identify
    from identification.model import read_model
    from identification.simulation.simulated import simulate_recording as simulate
    from vision.check.from_dataset import check_dataset as check
    from vision.recorded import synchronise_recording as synchronise

__version__ = version("xneck")

__all__ = [
    "Refused",
    "as_record",
    "check",
    "diagnose",
    "identify",
    "in_words",
    "read_dataset",
    "read_model",
    "simulate",
    "synchronise",
    "write_dataset",
]

_FROM = {
    "as_record": "identification.diagnosis.record:as_json",
    "check": "vision.check.from_dataset:check_dataset",
    "diagnose": "identification.diagnosis.diagnose:diagnose",
    "identify": "identification.estimates:estimate",
    "in_words": "identification.diagnosis.record:as_text",
    "read_dataset": "identification.dataset_file:read_dataset",
    "read_model": "identification.model:read_model",
    "simulate": "identification.simulation.simulated:simulate_recording",
    "synchronise": "vision.recorded:synchronise_recording",
    "write_dataset": "identification.dataset_file:write_dataset",
}
"""where each name lives"""


def __getattr__(name: str) -> Any:
    if name not in _FROM:
        raise AttributeError(f"module 'xneck' has no attribute {name!r}")
    module, own = _FROM[name].split(":")
    found = globals()[name] = getattr(importlib.import_module(module), own)
    return found


def __dir__() -> list[str]:
    return [*globals(), *_FROM]
