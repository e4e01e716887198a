"""Fasquelle's tables 1 and 2: parameters of this recording beside those that were published."""

from collections.abc import Sequence
from dataclasses import dataclass

from identification.fasquelle.method import MAX_RELATIVE_SIGMA_PERCENT, FasquelleFit
from identification.fasquelle.tables import table_rows
from xneck.report import fasquelle_published
from xneck.report.number_text import number_text, percent
from xneck_foundation.unit_text import printed_unit

PRINTED_UNITS = {"Pa": ("GPa", 1e-9), "Pa s": ("MPa s", 1e-6)}
"""units in which Fasquelle prints a table, by the SI unit, and the factor from SI"""


@dataclass(frozen=True)
class Cell:
    """A value with its relative sigma, and whether it is identified."""

    value: str
    relative: str = ""
    identified: bool = True


EMPTY_CELL = Cell("–")


@dataclass(frozen=True)
class FasquelleTable:
    """A table of Fasquelle: columns of this recording, then the published ones (none for an arm with other cables)."""

    title: str
    columns: tuple[str, ...]
    reference: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[Cell, ...], tuple[Cell, ...]], ...]
    """label, unit, our cells, the published cells"""


def fasquelle_table(
    title: str, fits: Sequence[FasquelleFit], published: Sequence[fasquelle_published.Column], cables: int
) -> FasquelleTable:
    """`fits` as columns, with the `published` ones as reference where `cables`, the arm's number, is that of Fasquelle's arm."""
    reference = tuple(published) if cables == fasquelle_published.CABLES else ()
    rows = []
    for label, unit, parameters in table_rows(list(fits)):
        printed, factor = PRINTED_UNITS.get(unit, (printed_unit(unit), 1.0))
        ours = tuple(
            Cell(number_text(factor * p.value), percent(p.relative_sigma_percent), p.identified) if p else EMPTY_CELL
            for p in parameters
        )
        theirs = tuple(_published_cell(column.get(label)) for column in reference)
        rows.append((label, printed, ours, theirs))
    titles = tuple(fit.title for fit in fits)
    return FasquelleTable(title, titles, titles if reference else (), tuple(rows))


def _published_cell(pair: tuple[str, str] | None) -> Cell:
    if pair is None:
        return EMPTY_CELL
    return Cell(pair[0], f"{pair[1]} %", float(pair[1]) <= MAX_RELATIVE_SIGMA_PERCENT)
