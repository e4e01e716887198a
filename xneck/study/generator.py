"""The generator of hidden effects, which stands in the samples of a checkout: no package holds it or shares code with it."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

from xneck_foundation.errors import Refused

_MODULE = "samples.generator.hidden.experiment"


def load_generator(samples: Path) -> ModuleType:
    """samples/generator/hidden/experiment.py, imported from there.

    Raises Refused where it is not there, or another one of that name has been imported.
    """
    file = samples.parent.joinpath(*_MODULE.split(".")).with_suffix(".py").resolve()
    what_to_do = "give the samples folder of a checkout with --samples"
    if samples.resolve().name != "samples" or not file.is_file():
        raise Refused(samples, "holds no generator", what_to_do)
    root = str(samples.resolve().parent)
    if root not in sys.path:
        # last: the packages that run are those installed, not this checkout's
        sys.path.append(root)
    module = importlib.import_module(_MODULE)
    if Path(str(module.__file__)).resolve() != file:
        raise Refused(samples, f"not this generator but {module.__file__} is imported", what_to_do)
    return module
