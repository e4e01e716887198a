"""xneck from Python: recordings to data sets, parameters, simulations and a diagnosis.

Each function does what the command of its name does, and writes no files of its own:

- `synchronise` a recording folder, or `read_dataset` of what `xneck sync` and `xneck run` wrote
- `check` whether camera and motors agree, `identify` friction and elasticity, `simulate` the recorded forces
- `observe` the joints of a log without a camera, or with `Observer` row by row; `calibrate_pose` finds what a model needs for it
- `discover` what law a residual follows, of this arm or of any other bench
- `diagnose` what the simulation gets wrong; `in_words` and `as_record` give the diagnosis as text and ready for JSON

An input that cannot be used raises `Refused`, which says which file, why, and what to do.

>>> import xneck
>>> monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
>>> diagnosis = xneck.diagnose([monday], [tuesday])  # fitted to the first, held against the second
>>> diagnosis.verdict
'cause'
>>> [cause["effect"] for cause in xneck.as_record(diagnosis)["causes"]]
['tip_payload']

The functions are imported when they are first used, so that `import xneck` is quick. Only a recording with a video needs OpenCV.
"""

import importlib
from typing import TYPE_CHECKING, Any

from xneck_foundation.errors import Refused
from xneck_foundation.version import VERSION

if TYPE_CHECKING:
    from diagnosis.diagnose import diagnose
    from diagnosis.record import as_json as as_record
    from diagnosis.record import as_text as in_words
    from discovery.discover import discover
    from identification.dataset.dataset_file import read_dataset, write_dataset
    from identification.estimates import estimate as identify
    from identification.model_file import read_model
    from identification.pose_calibration import calibrate_pose
    from identification.simulation.simulated_recording import simulate_recording as simulate
    from observation.observed_log import observe_log as observe
    from observation.observer import Observer
    from synchronisation.check.from_dataset import check_dataset as check
    from xneck.recording.stages import synchronise_recording as synchronise

__version__ = VERSION

__all__ = [
    "Observer",
    "Refused",
    "as_record",
    "calibrate_pose",
    "check",
    "diagnose",
    "discover",
    "identify",
    "in_words",
    "observe",
    "read_dataset",
    "read_model",
    "simulate",
    "synchronise",
    "write_dataset",
]

_LOCATIONS = {
    "Observer": "observation.observer:Observer",
    "as_record": "diagnosis.record:as_json",
    "calibrate_pose": "identification.pose_calibration:calibrate_pose",
    "check": "synchronisation.check.from_dataset:check_dataset",
    "diagnose": "diagnosis.diagnose:diagnose",
    "discover": "discovery.discover:discover",
    "identify": "identification.estimates:estimate",
    "in_words": "diagnosis.record:as_text",
    "observe": "observation.observed_log:observe_log",
    "read_dataset": "identification.dataset.dataset_file:read_dataset",
    "read_model": "identification.model_file:read_model",
    "simulate": "identification.simulation.simulated_recording:simulate_recording",
    "synchronise": "xneck.recording.stages:synchronise_recording",
    "write_dataset": "identification.dataset.dataset_file:write_dataset",
}
"""module and name of each function"""


def __getattr__(name: str) -> Any:
    if name not in _LOCATIONS:
        raise AttributeError(f"module 'xneck' has no attribute {name!r}")
    module, attribute = _LOCATIONS[name].split(":")
    value = globals()[name] = getattr(importlib.import_module(module), attribute)
    return value


def __dir__() -> list[str]:
    return [*globals(), *_LOCATIONS]
