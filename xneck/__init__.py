"""xneck from Python: recordings to data sets, parameters, simulations and a diagnosis.

Each function does what the command of its name does, and writes no files of its own:

- `synchronise` a recording folder, `dataset_from_arrays`, or `read_dataset` of what `xneck sync` and `xneck run` wrote
- `check` whether camera and motors agree, `identify` friction and elasticity, `simulate` the recorded forces
- `read_neck`, `read_log` and `read_model`; `neck.with_({...})` and `model.with_(k=...)` are the same with other numbers
- `simulate_motion` that was designed and not played yet; `mujoco_model` is the arm for MuJoCo
- `observe` the joints of a log without a camera, or with `Observer` row by row; `calibrate_pose` finds what a model needs for it
- `discover` what law a residual follows, of this arm or of any other bench
- `diagnose` what the simulation gets wrong
- `in_words` and `as_record` give any of these results as text and ready for JSON, `figures` as matplotlib figures, `to_arrays`,
  `to_pandas` and `to_xarray` its series

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
    from discovery.discover import discover
    from identification.dataset.dataset_file import read_dataset, write_dataset
    from identification.estimates import estimate as identify
    from identification.model_file import read_model, write_model
    from identification.pose_calibration import calibrate_pose
    from identification.simulation.simulated_motion import simulate_motion
    from identification.simulation.simulated_recording import simulate_recording as simulate
    from mechanism.description import read_neck
    from observation.observed_log import observe_log as observe
    from observation.observer import Observer
    from synchronisation.check.from_dataset import check_dataset as check
    from synchronisation.encoder_log import read_log
    from synchronisation.from_arrays import dataset_from_arrays
    from xneck.export.motion_file import read_motion
    from xneck.export.mujoco_file import mujoco_model, mujoco_start
    from xneck.export.result_figures import figures
    from xneck.export.result_words import as_record, in_words
    from xneck.export.tables import to_arrays, to_pandas, to_xarray
    from xneck.recording.stages import synchronise_recording as synchronise

__version__ = VERSION

__all__ = [
    "Observer",
    "Refused",
    "as_record",
    "calibrate_pose",
    "check",
    "dataset_from_arrays",
    "diagnose",
    "discover",
    "figures",
    "identify",
    "in_words",
    "mujoco_model",
    "mujoco_start",
    "observe",
    "read_dataset",
    "read_log",
    "read_model",
    "read_motion",
    "read_neck",
    "simulate",
    "simulate_motion",
    "synchronise",
    "to_arrays",
    "to_pandas",
    "to_xarray",
    "write_dataset",
    "write_model",
]

_LOCATIONS = {
    "as_record": "xneck.export.result_words:as_record",
    "Observer": "observation.observer:Observer",
    "calibrate_pose": "identification.pose_calibration:calibrate_pose",
    "check": "synchronisation.check.from_dataset:check_dataset",
    "dataset_from_arrays": "synchronisation.from_arrays:dataset_from_arrays",
    "diagnose": "diagnosis.diagnose:diagnose",
    "discover": "discovery.discover:discover",
    "figures": "xneck.export.result_figures:figures",
    "identify": "identification.estimates:estimate",
    "in_words": "xneck.export.result_words:in_words",
    "mujoco_model": "xneck.export.mujoco_file:mujoco_model",
    "mujoco_start": "xneck.export.mujoco_file:mujoco_start",
    "observe": "observation.observed_log:observe_log",
    "read_dataset": "identification.dataset.dataset_file:read_dataset",
    "read_log": "synchronisation.encoder_log:read_log",
    "read_model": "identification.model_file:read_model",
    "read_motion": "xneck.export.motion_file:read_motion",
    "read_neck": "mechanism.description:read_neck",
    "simulate": "identification.simulation.simulated_recording:simulate_recording",
    "simulate_motion": "identification.simulation.simulated_motion:simulate_motion",
    "synchronise": "xneck.recording.stages:synchronise_recording",
    "to_arrays": "xneck.export.tables:to_arrays",
    "to_pandas": "xneck.export.tables:to_pandas",
    "to_xarray": "xneck.export.tables:to_xarray",
    "write_dataset": "identification.dataset.dataset_file:write_dataset",
    "write_model": "identification.model_file:write_model",
}
"""module and name of each function"""


def __getattr__(name: str) -> Any:
    if name not in _LOCATIONS:
        raise AttributeError(f"module 'xneck' has no attribute {name!r}")
    module, attribute = _LOCATIONS[name].split(":")
    value = getattr(importlib.import_module(module), attribute)
    if not isinstance(value, type):
        value = importlib.import_module("xneck.argument_kinds").checked(value, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *_LOCATIONS]
