"""Validation of a data set that was read from a file: its columns, their sizes, its clocks."""

from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np

from identification.dataset.clock_record import validate_clock_record
from identification.dataset.dataset import DataSet
from identification.dataset.frames import MAX_SIGMA_RAD
from identification.dataset.series import Series, check_size, check_time
from identification.files.mcap_losses import rows_after_gaps
from mechanism.geometry import check_angles
from xneck_foundation.errors import Refused

MAX_MAGNITUDE_SI = 1e9
"""largest magnitude of any number in SI units: a motor at 1e5 rad/s that reverses within 0.1 ms has 1e9 rad/s^2
(docs/thresholds.md)"""
_JOINTS = ("alpha", "alpha_d", "alpha_dd")
_CABLES = ("theta", "theta_d", "theta_dd")
_SIGMAS = tuple(f"sigma_{stem}" for stem in (*_JOINTS, *_CABLES))


def validate_dataset(data: DataSet, where: str | Path) -> None:
    """Raises Refused where the data set cannot be computed with.

    That is where `state` or `fasquelle` lack columns, hold values that are not finite or have uneven time steps, or where angles,
    log or clock do not fit them.
    """
    n, m = data.neck.N, data.neck.M
    validate_clock_record(data.clock, f"{where}: clock")
    for name in ("state", "fasquelle"):
        series: Series = getattr(data, name)
        place = f"{where}:/{name}"
        forces = ("f",) if "f1" in series.columns else ()
        for stems, count in ((_JOINTS, n), ((*_CABLES, "x", *forces), m)):
            for stem in stems:
                _require_columns(series, stem, count, place)
        sigma_stems = [(s, n if "alpha" in s else m) for s in _SIGMAS]
        for stem, count in (*sigma_stems, ("bridged", n), ("vision", n), ("vision_d", n)):
            if f"{_column(stem, 1)}" in series.columns:
                _require_columns(series, stem, count, place)
        if gaps := rows_after_gaps(series.time):
            raise Refused(place, f"rows are missing before {series.time[gaps[0]]:.3f} s", "give rows of even steps")
        check_size(series.columns, MAX_MAGNITUDE_SI, place)
        check_angles(data.arm, series.matrix("alpha"), place)
        if not np.ptp(series.matrix("theta"), axis=0).any():
            raise Refused(place, "no motor moves in it", "record a motion")
        for stem in _SIGMAS:
            if np.any(_matrix(series, stem) < 0):
                raise Refused(place, f"{stem} is negative", "give standard deviations")
    for name, stems in (("angles", (("alpha", n), ("sigma", n), ("common", n))), ("log", (("theta", m), ("f", m)))):
        series, place = getattr(data, name), f"{where}:/{name}"
        if not len(series):
            continue
        check_time(series.time, place)
        check_size(series.columns, MAX_MAGNITUDE_SI, place)
        for stem, count in stems:
            if series.matrix(stem).shape[1] not in (0, count):
                raise Refused(place, f"has {series.matrix(stem).shape[1]} columns {stem}, expected {count}")
    alpha, sigma = data.angles.matrix("alpha"), data.angles.matrix("sigma")
    known = sigma[np.isfinite(alpha)] if sigma.shape == alpha.shape else np.empty(0)
    if not np.all((known > 0) & (known <= MAX_SIGMA_RAD)):
        word = f"has a sigma that is not within 0 and {MAX_SIGMA_RAD:.3g}"
        raise Refused(f"{where}:/angles", word, "give standard deviations in rad, or none")
    if data.covariance is not None:
        _check_covariance(data.covariance, n, f"{where}:/covariance")


def _check_covariance(series: Series, n: int, place: str) -> None:
    check_time(series.time, place)
    names = [_column(stem, i + 1) for stem in _JOINTS for i in range(n)]
    for a, b in combinations_with_replacement(names, 2):
        column = f"cov_{a}_{b}"
        if column not in series.columns or not np.all(np.isfinite(series.columns[column])):
            raise Refused(
                place, f"lacks the column {column}, or numbers in it", "make the data set anew with `xneck sync`"
            )
    check_size(series.columns, MAX_MAGNITUDE_SI**2, place)


def _column(stem: str, number: int) -> str:
    """Name of a column by its stem and number: alpha_d of joint 1 is alpha1_d."""
    for suffix in ("_dd", "_d"):
        if stem.endswith(suffix):
            return f"{stem.removesuffix(suffix)}{number}{suffix}"
    return f"{stem}{number}"


def _matrix(series: Series, stem: str) -> np.ndarray:
    suffix = next((s for s in ("_dd", "_d") if stem.endswith(s)), "")
    return series.matrix(stem.removesuffix(suffix), suffix)


def _require_columns(series: Series, stem: str, count: int, place: str) -> None:
    """Raises Refused unless columns 1..count of `stem`, and no more, are there and finite."""
    columns = [_column(stem, k + 1) for k in range(count)]
    for column in columns:
        if column not in series.columns:
            raise Refused(place, f"lacks the column {column}", "make the data set anew with `xneck sync`")
        if not np.all(np.isfinite(series.columns[column])):
            row = int(np.argmin(np.isfinite(series.columns[column]))) + 1
            raise Refused(place, f"{column} is not a number in row {row}", "make the data set anew with `xneck sync`")
    if (extra := _column(stem, count + 1)) in series.columns:
        raise Refused(place, f"has the column {extra}, the arm has no such part", "is it this arm's neck.yaml?")
