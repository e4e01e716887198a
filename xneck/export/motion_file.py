"""motion.csv: a designed motion, read for a simulation."""

from pathlib import Path

from identification.dataset.series import Series
from identification.simulation.simulated_motion import motion_columns
from mechanism.description import Neck
from synchronisation.csv_table import read_table


def read_motion(path: str | Path, neck: Neck) -> Series:
    """Columns alphaI, thetaJ and fJ of a motion that `xneck design` wrote for this arm.

    Raises Refused where the file cannot be read, or a column is missing.

    >>> import xneck
    >>> motion = xneck.read_motion("motion.csv", xneck.read_neck("samples/recording/neck.yaml"))
    >>> motion.matrix("f").shape[1]  # motors
    4
    """
    return read_table(path, motion_columns(neck))
