"""The check of a data set as its file holds it, made by `sync` or by hand."""

from identification.dataset import DataSet
from identification.frames import frames_of
from vision.check.elongations import Baseline, Check, baseline_of, check_elongations
from xneck.errors import Refused


def check_dataset(data: DataSet, baseline: DataSet | None = None, where: str = "baseline") -> Check:
    """With `baseline`, a data set of the same arm that is known to be healthy; raises Refused where that one is not.

    Raises Refused where a data set holds no forces: then nothing says how far the cables stretch. Both are computed with
    the checked data set's neck.yaml.
    """
    for one, name in ((data, "check"), (baseline, where)):
        if one is not None and "f1" not in one.state.columns:
            raise Refused(name, "the data set holds no forces f", "log the force command of every motor")
    known: Baseline | None = None
    if baseline is not None:
        known = baseline_of(data.arm, baseline.state, frames_of(baseline), _clock_sigma(baseline), where)
    return check_elongations(data.arm, data.state, frames_of(data), _clock_sigma(data), known)


def _clock_sigma(data: DataSet) -> float:
    return float(data.clock.get("offset_sigma_s") or 0.0)
