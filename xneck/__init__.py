"""What all parts of xneck stand on: errors, strict files, whole outputs, estimates; and the way in from Python.

Functions are named after the commands and do what these do, without files of their own. They live in the packages above this
one and are fetched when they are first asked for, so that `import xneck` costs nothing and the command line stays quick.

>>> import xneck
>>> monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
>>> xneck.diagnose([monday], [tuesday]).verdict
'cause'
"""

import importlib
from typing import TYPE_CHECKING, Any

from xneck_foundation.errors import Refused
from xneck_foundation.version import VERSION

if TYPE_CHECKING:
    from diagnosis.diagnose import diagnose
    from diagnosis.record import as_json as as_record
    from diagnosis.record import as_text as in_words
    from identification.dataset.dataset_file import read_dataset, write_dataset
    from identification.estimates import estimate as identify
    from identification.model_file import read_model
    from identification.simulation.simulated import simulate_recording as simulate
    from synchronisation.check.from_dataset import check_dataset as check
    from xneck.recording.stages import synchronise_recording as synchronise

__version__ = VERSION

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
    "as_record": "diagnosis.record:as_json",
    "check": "synchronisation.check.from_dataset:check_dataset",
    "diagnose": "diagnosis.diagnose:diagnose",
    "identify": "identification.estimates:estimate",
    "in_words": "diagnosis.record:as_text",
    "read_dataset": "identification.dataset.dataset_file:read_dataset",
    "read_model": "identification.model_file:read_model",
    "simulate": "identification.simulation.simulated:simulate_recording",
    "synchronise": "xneck.recording.stages:synchronise_recording",
    "write_dataset": "identification.dataset.dataset_file:write_dataset",
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
