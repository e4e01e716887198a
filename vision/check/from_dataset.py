"""The check of a data set as its file holds it, made by `sync` or by hand."""

import numpy as np

from identification.dataset import DataSet
from identification.state import Seen
from mechanism.arm import Arm
from vision.angles import DEFAULT_SIGMA, Angles
from vision.check.elongations import Baseline, Check, baseline_of, check_elongations
from vision.clocks.record import log_time
from xneck.errors import Refused

FRAME_HZ = 25.0
"""at which the state stands in for frames"""


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
        known = baseline_of(data.arm, baseline.state, seen_in(data.arm, baseline), _clock_sigma(baseline), where)
    return check_elongations(data.arm, data.state, seen_in(data.arm, data), _clock_sigma(data), known)


def seen_in(arm: Arm, data: DataSet) -> Seen:
    """Frames on the log's clock; the state, thinned, where the data set has no frames or no clock for them."""
    alpha = data.angles.matrix("alpha")
    if "offset_s" in data.clock and alpha.shape[1] == arm.N:
        sigma, common = data.angles.matrix("sigma"), data.angles.matrix("common")
        sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA)
        angles = Angles(data.angles.time, alpha, sigma, common=common if common.shape == alpha.shape else None)
        return Seen(log_time(data.clock, angles.time), alpha, angles.white, angles.shared)
    state = data.state
    rows = slice(None, None, max(1, round(1 / (FRAME_HZ * float(np.mean(np.diff(state.time)))))))
    alpha, sigma = state.matrix("alpha")[rows], state.matrix("sigma_alpha")[rows]
    sigma = sigma if sigma.shape == alpha.shape else np.full(alpha.shape, DEFAULT_SIGMA)
    return Seen(state.time[rows], alpha, sigma, np.zeros_like(sigma))


def _clock_sigma(data: DataSet) -> float:
    return float(data.clock.get("offset_sigma_s") or 0.0)
