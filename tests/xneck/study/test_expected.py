"""The truth in the numbers that a diagnosis measures."""

import pytest

from tests.xneck.study.records import TRUTH
from xneck.study.expected import expected


def test_creep_in_line_is_creep_beside() -> None:
    """A spring k in line with a Kelvin element of compliance share/k: immediate and lasting stiffness, and their time."""
    own = {"effect": "cable_creep", "where": "all", "parameters": {"share": 0.25, "tau": 5.0}}
    numbers = expected(own, TRUTH)
    for j, k in enumerate(TRUTH["k"]):
        assert k - numbers["km", j + 1] == pytest.approx(1 / (1 / k + 0.25 / k))
    assert numbers["tau", None] == pytest.approx(4.0)


def test_cubic_hardening_is_the_power_three() -> None:
    own = {"effect": "cable_hardening", "where": "all", "parameters": {"k31": 2e7, "k32": 1e7}}
    numbers = expected(own, TRUTH)
    x = 2e-3
    assert numbers["k2", 1] * 5e-3**2 * (x / 5e-3) ** numbers["nh", None] == pytest.approx(2e7 * x**3)
    assert expected({**own, "parameters": {"growth1": 80.0}}, TRUTH) == {}
