"""What Fasquelle 2021 printed for its own prototype: a reference beside our tables that enters no computation.

Values and relative sigma in %, as printed and in the printed units, by the labels of `identification.fasquelle.tables`.
"""

from collections.abc import Mapping

CABLES = 4
"""number of cables of Fasquelle's arm; beside an arm with another number its values would mean nothing"""

Column = Mapping[str, tuple[str, str]]


def _column(**by_name: str) -> Column:
    """A column of a table: labels `name(1)`, `name(2)`, ... from text `value sigma, value sigma, ...` in the order of cables."""
    out: dict[str, tuple[str, str]] = {}
    for name, printed in by_name.items():
        pairs = [pair.split() for pair in printed.split(",")]
        out |= {f"{name}({j + 1})": (value, sigma) for j, (value, sigma) in enumerate(pairs)}
    return out


DRY_AND_VISCOUS = _column(
    fs="12.91 5.62, 16.72 4.55, 18.11 4.25, 16.09 1.85",
    fv="0.0468 56.85, 0.0463 72.11, 0.0464 83.42, 0.0072 105.96",
)
DRY_ONLY = _column(fs="14.13 2.52, 17.70 2.02, 18.97 1.88, 16.29 1.25")
MODEL_1 = _column(
    fs="14.42 1.68, 17.65 1.38, 18.77 1.32, 16.18 0.88",
    k="10454 1.37, 9256 1.60, 8319 1.85, 5336 1.28",
    ca="805 30.5, 333 68.7, −218 94.3, 370 64.3",
)
MODEL_2 = {
    **_column(fs="14.38 1.73, 17.49 1.44, 18.41 1.38, 16.32 0.90"),
    "E": ("4.04", "0.83"),
    "c": ("139.8", "45.5"),
}
MODEL_3 = {
    **_column(fs="14.32 1.72, 17.48 1.42, 18.48 1.35, 16.29 0.89"),
    "E": ("1.23", "0.81"),
    "c": ("57.4", "32.88"),
}
TABLE_1 = (DRY_AND_VISCOUS, DRY_ONLY)
TABLE_2 = (MODEL_1, MODEL_2, MODEL_3)
MEAN_TENSION_ERROR = ("6.88", "9.84", "9.64")
"""N, of elastic models 1, 2, 3"""
