"""What stands in a cell is read as the writer meant it, or named."""

import pytest

from synchronisation.csv_cell import not_a_number, number_in, with_point


@pytest.mark.parametrize(
    ("cell", "number"),
    [
        ("12,645", 12.645),
        ("12.645", 12645.0),
        ("-1.234.567,5", -1234567.5),
        ("0.123", 0.123),
        ("12.6", 12.6),
        ("3", 3.0),
    ],
)
def test_points_between_thousands_are_none_before_decimals(cell: str, number: float) -> None:
    """In a table with decimal commas: counts of 12.645 were taken for a dozen, and their motion for another one."""
    assert number_in(with_point(cell, ",")) == number


def test_a_table_with_decimal_points_stays_as_it_is() -> None:
    assert number_in(with_point("12.645", ".")) == 12.645


@pytest.mark.parametrize(("cell", "what"), [("\N{MINUS SIGN}0.5", "minus sign"), ("0.1D+00", "Fortran exponent")])
def test_numbers_that_look_like_some_are_named(cell: str, what: str) -> None:
    said, do = not_a_number(cell)
    assert what in said
    assert do
