"""A ratio has no unit where people read it."""

import re

import pytest

from tests.paths import ROOT
from xneck_foundation.unit_text import printed_unit, product_unit, with_unit


@pytest.mark.parametrize(
    ("unit", "printed", "said"), [("1", "", "0.1"), ("N", "N", "0.1 N"), ("1/rad", "1/rad", "0.1 1/rad")]
)
def test_only_the_unit_of_a_ratio_is_left_out(unit: str, printed: str, said: str) -> None:
    assert printed_unit(unit) == printed
    assert with_unit("0.1", unit) == said


def test_products_have_the_units_that_their_factors_have() -> None:
    units = [product_unit(a, b) for a, b in (("N", "rad"), ("1", "rad"), ("N", "1"), ("1", "1"))]
    assert units == ["N rad", "rad", "N", "1"]


def test_no_text_is_made_with_a_parameters_unit_as_it_is() -> None:
    """Parameters and terms may be ratios; gains and channels never are."""
    packages = ("xneck", "diagnosis", "identification", "synchronisation", "calibration", "discovery")
    printed = re.compile(r"\{\w*\b(p|term|e\.term|entry\.term|first\[0\])(\.unit|\[['\"]unit['\"]\])")
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for package in packages
        for path in sorted((ROOT / package).rglob("*.py"))
        for line in path.read_text(encoding="utf-8").splitlines()
        if printed.search(line)
    ]
    assert [line for line in found if "diagnosis_figures" not in line] == []
