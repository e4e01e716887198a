"""Whether a data set was made with a log: frames are on that log's clock, and on no other's."""

import numpy as np

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, interpolated
from xneck_foundation.errors import Refused

MAX_BESIDE_SHARE, MAX_BESIDE_COUNTS = 0.05, 5.0
"""share of the way that motors turn, and counts beside it, by which a data set's motors may stand beside a log's in the median,
that is of the same recording (docs/thresholds.md)"""


def check_same_log(data: DataSet, log: Series, where: str) -> None:
    """Raises Refused where the motors of a data set turn otherwise than those of a log, (T,) rows, do at the same times."""
    theta, own = log.matrix("theta"), data.state.matrix("theta")
    within = (log.time >= data.state.time[0]) & (log.time <= data.state.time[-1])
    if not within.any() or theta.shape[1] != own.shape[1]:
        return  # what asks for frames within the log, and for so many motors, says so
    beside = np.abs(theta[within] - interpolated(log.time[within], data.state.time, own))
    way = np.abs(theta[within] - np.median(theta[within], axis=0))
    counts = float(np.sum(data.count_angles))
    off, turned = (float(np.sum(np.median(part, axis=0))) for part in (beside, way))
    if off > MAX_BESIDE_SHARE * turned + MAX_BESIDE_COUNTS * counts:
        raise Refused(
            where,
            f"was made with another log: its motors are {off / theta.shape[1]:.3g} rad beside this log's at the same times, which "
            f"turn by {turned / theta.shape[1]:.3g} rad (medians)",
            "give the data set that `xneck sync` makes with this log",
        )
