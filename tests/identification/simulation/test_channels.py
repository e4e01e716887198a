"""Errors of a simulation as a person reads them."""

import math

import pytest

from identification.simulation.channels import Channel, as_text


@pytest.mark.parametrize(
    ("channel", "row"),
    [
        (
            Channel("alpha1", math.radians(0.5), math.radians(0.2), "rad", 1.4),
            ["alpha1", "0.5", "0.2", "2.50", "1.40", "deg"],
        ),
        (Channel("f2", 3.0, 4.0, "N", 1.1), ["f2", "3", "4", "0.75", "1.10", "N"]),
    ],
)
def test_a_row_has_its_numbers_in_the_unit_at_its_end(channel: Channel, row: list[str]) -> None:
    """Error over noise floor, as they are printed, is the ratio that is printed."""
    head, text = as_text([channel]).splitlines()
    assert text.split() == row
    assert head.split() == ["channel", "rms", "noise", "floor", "ratio", "95", "%"]
    error, floor, ratio = map(float, text.split()[1:4])
    assert error / floor == pytest.approx(ratio, abs=5e-3)
