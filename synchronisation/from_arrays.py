"""A data set from arrays that are in memory: joint angles from anywhere, and the motors' log."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered_columns
from mechanism.description import Neck
from mechanism.neck_text import neck_text
from synchronisation.angles import checked_angles
from synchronisation.encoder_log import motor_log
from synchronisation.synchronise import synchronise
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import note_inputs, provenance

Array = NDArray[np.float64]
_WHERE = "arrays"
_OTHER_KINDS = {"M": "dates", "m": "durations", "U": "text", "S": "bytes", "c": "complex numbers", "b": "truth values"}
"""what is no number, by the letter that NumPy has for it"""
_NO_CONVERSIONS = {"motors.theta_scale": 1.0, "motors.theta_sign": 1, "motors.f_scale": 1.0, "alpha_zero": None}
"""the keys of neck.yaml that say how files are converted, and what converts nothing"""
_CONVERTING_KEYS = ("theta_scale", "theta_sign", "f_scale", "time_scale")


def dataset_from_arrays(
    neck: Neck,
    frame_time: ArrayLike,
    alpha: ArrayLike,
    log_time: ArrayLike,
    theta: ArrayLike,
    f: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
) -> DataSet:
    """The data set of joint angles and a motors' log that are arrays, as `xneck sync` makes it of files.

    frame_time (F,), s, on the clock of what measured the angles; alpha (F, N), rad, zero where the arm stands straight, NaN or
    masked where a joint was not measured; sigma (F, N), rad, its standard deviation, where it is known. log_time (T,), s, on the
    controller's clock; theta (T, M), rad, of the motors, growing as the cable is wound in, and f (T, M), N at the cables.

    So are the series of a data set, and what `read_log` gives: scales, signs and zeros that `neck` has for files are not applied to
    arrays. The clocks are put on one, also where they are the same: the offset then comes out near zero, with its standard
    deviation.

    Raises Refused where shapes do not fit the arm or each other, a value cannot be what it is said to be, or the clocks cannot be
    aligned.

    >>> import xneck
    >>> monday = xneck.read_dataset("monday.mcap")
    >>> frames, log = monday.angles, monday.log
    >>> again = xneck.dataset_from_arrays(
    ...     monday.neck, frames.time, frames.matrix("alpha"), log.time, log.matrix("theta"), log.matrix("f"), frames.matrix("sigma")
    ... )
    >>> abs(again.clock["offset_s"] - monday.clock["offset_s"]) < monday.clock["offset_sigma_s"]
    True
    """
    angles = _series(frame_time, {"alpha": alpha, "sigma": sigma}, neck.N)
    log = _series(log_time, {"theta": theta, "f": f}, neck.M)
    read = checked_angles(angles, neck.N, _WHERE, {"source": _WHERE})
    origin = provenance(note_inputs({}))
    plain = neck.with_(_NO_CONVERSIONS)
    try:
        data = synchronise(plain, "", read, motor_log(log, plain, _WHERE), origin)
    except Refused as refusal:
        if not any(key in refusal.what + refusal.do for key in _CONVERTING_KEYS):
            raise
        do = f"convert the arrays, or let xneck.read_log read the log's file ({refusal.do})"
        raise Refused(refusal.where, refusal.what, do) from refusal
    return replace(data, neck=neck, neck_yaml=neck_text(neck))


def _series(time: ArrayLike, parts: dict[str, ArrayLike | None], count: int) -> Series:
    """Numbered columns of arrays (T, count) by their stems; a part that is None is left out."""
    at = _numbers("time", time)
    if at.ndim != 1 or len(at) < 2:
        raise Refused(_WHERE, f"time has the shape {at.shape}, expected (T,)", "give a time for each row")
    columns: dict[str, Array] = {}
    for stem, part in parts.items():
        if part is None:
            continue
        values = _numbers(stem, part)
        if values.shape != (len(at), count):
            raise Refused(
                _WHERE,
                f"{stem} has the shape {values.shape}, expected {(len(at), count)}",
                "a row a time, a column a part of the arm",
            )
        columns |= numbered_columns(stem, values)
    return Series(at, columns)


def _numbers(what: str, values: ArrayLike) -> Array:
    """An array of numbers, NaN where it is masked. Raises Refused where it holds something else."""
    try:
        array = np.ma.asarray(values)
        if array.dtype.kind in _OTHER_KINDS:
            raise Refused(_WHERE, f"{what} holds {_OTHER_KINDS[array.dtype.kind]}", "give numbers: s, rad, N")
        return np.ma.filled(array.astype(float), np.nan)
    except (TypeError, ValueError) as error:
        raise Refused(
            _WHERE, f"{what} is no array of numbers ({error})", "give rows of equal length: s, rad, N"
        ) from error
