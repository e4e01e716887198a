"""A log without the rows in which a controller repeated one sample while the motors moved on."""

from pathlib import Path

import numpy as np

from identification.dataset.series import Series
from synchronisation.clocks.log_gaps import repair_log
from xneck_foundation.one_line import counted
from xneck_foundation.recovery import warn_recovered


def true_rows(log: Series, path: str | Path) -> Series:
    """The log's rows that were sampled, with a warning where others are left out; `path` says where they come from."""
    repaired = repair_log(log)
    if repaired.repeated_rows:
        first = float(log.time[np.argmin(np.isin(log.time, repaired.log.time))])
        warn_recovered(
            path,
            f"{counted(repaired.repeated_rows, 'row')} repeat the one before, all columns, while motors moved on (the first at "
            f"{first:.6g} s): they were left out, as if the log had a gap there",
        )
    return repaired.log
