"""Checks of parts: what lasts must be seen in half of them, what happens once counts wherever it is."""

from typing import Any

import pytest

from synchronisation.check.check import CableCheck, Check
from synchronisation.check.checked_parts import merged_checks

DRUM = {"fault": "drum_radius", "where": "motor 1", "size": 0.02, "unit": "1", "sigma": 1e-3}


def part(*faults: dict[str, Any], mean: float = 1.0) -> Check:
    cable = CableCheck(
        cable=1,
        elongation_mean=mean,
        elongation_rms=0.0,
        unexplained_rms=0.1,
        expected_rms=0.1,
        compliance=2.0,
        compliance_sigma=0.2,
        offset=0.0,
    )
    return Check((cable,), faults)


def slip(when: float) -> dict[str, Any]:
    return {"fault": "winch_slip", "where": "cable 2", "size": 1e-3, "unit": "m", "sigma": 1e-5, "when_s": when}


def test_a_single_part_is_as_it_is() -> None:
    one = part(DRUM)
    assert merged_checks([one]) is one


def test_a_lasting_fault_of_few_parts_is_said_and_no_verdict() -> None:
    check = merged_checks([part(DRUM), part(), part()])
    assert check.verdict == "consistent"
    assert check.as_json()["in_few_parts"] == [DRUM | {"parts": 1, "of_parts": 3}]


def test_a_lasting_fault_of_most_parts_is_named_with_the_middle_size() -> None:
    sizes = [part(DRUM | {"size": size}) for size in (0.03, 0.02, 0.021)]
    check = merged_checks([*sizes, part()])
    assert check.verdict == "inconsistent"
    assert check.faults == (DRUM | {"size": 0.021, "parts": 3, "of_parts": 4},)
    assert check.in_few_parts == ()


def test_a_slip_counts_once_and_two_are_two() -> None:
    check = merged_checks([part(slip(118.9)), part(slip(119.0)), part(slip(300.0)), part()])
    assert [fault["when_s"] for fault in check.faults] == [118.9, 300.0]
    assert check.as_json()["usable"] == "in part"


def test_a_cable_that_moves_from_part_to_part_has_that_in_its_rms() -> None:
    (cable,) = merged_checks([part(mean=1.0), part(mean=3.0)]).cables
    assert (cable.elongation_mean, cable.elongation_rms) == pytest.approx((2.0, 1.0))
    assert cable.compliance_sigma == pytest.approx(0.2 / 2**0.5)
