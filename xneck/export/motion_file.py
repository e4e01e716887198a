"""motion.csv: a designed motion, read for a simulation."""

from pathlib import Path

from identification.dataset.series import Series
from identification.simulation.simulated_motion import check_motion, motion_columns
from mechanism.description import Neck
from synchronisation.csv_lines import file_line
from synchronisation.csv_table import PLAIN, read_table
from xneck_foundation.file_kind import refuse_other_kind


def read_motion(path: str | Path, neck: Neck) -> Series:
    """Columns alphaI, thetaJ and fJ of a motion that `xneck design` wrote for this arm.

    Raises Refused where the file cannot be read, a column, a number or rows are missing, or times are in no seconds.

    >>> import xneck
    >>> motion = xneck.read_motion("motion.csv", xneck.read_neck("samples/recording/neck.yaml"))
    >>> motion.matrix("f").shape[1]  # motors
    4
    """
    path = Path(path)
    refuse_other_kind(path, (".csv",))
    motion = read_table(path, motion_columns(neck))
    check_motion(motion, neck, path, file_line(path, PLAIN.separator))
    return motion
