"""Numbers as people read them."""

import pytest

from xneck.report.number_text import file_size, number_text, with_sigma
from xneck.report.words import join_words


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (number_text(10454.2), "10\u2009454"),
        (number_text(-0.0468, 3), "−0.0468"),
        (number_text(1.5e-9, 2), "1.5 × 10⁻⁹"),
        (number_text(float("nan")), "not known"),
        (with_sigma(5.99954, 0.000177), "5.99954 ± 0.00018"),
        (with_sigma(812.3, 14.0), "812 ± 14"),
        (with_sigma(3.0, float("inf")), "3.000 ± not known"),
        (file_size(679310), "679 kB"),
        (join_words(["a", "b", "c"]), "a, b and c"),
    ],
)
def test_numbers_as_people_read_them(text: str, expected: str) -> None:
    assert text == expected
