"""The arm at one glance, for arms and causes of all kinds: no text leaves the picture or covers another."""

from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page

from diagnosis.arm_error import ArmError, WorstPose
from diagnosis.cause import Cause
from diagnosis.effects import EFFECTS
from mechanism.arm import arm_of
from tests.html_page import label_faults
from tests.mechanism.test_neck_template import described
from xneck.report.arm_overview import error_words, places_panel
from xneck.report.style import drawing
from xneck_foundation.parameter import Parameter


def some_error(joints: int) -> ArmError:
    alpha = np.zeros(joints)
    large, small = np.linspace(0.8, 5.4e-4, joints + 1)[1:], np.full(joints, 4.9e-4)
    return ArmError(large, small, small, 0.1234, 1.1e-4, WorstPose(0, 1.0, alpha, alpha, alpha))


@pytest.mark.parametrize(("mechanisms", "cables"), [(1, 1), (1, 8), (2, 6), (3, 4), (6, 8)])
def test_labels_stay_apart(mechanisms: int, cables: int, browser_page: Page, tmp_path: Path) -> None:
    """One to five causes beside the arm, drawn at random among all that there are and wherever they may sit."""
    arm = arm_of(described(mechanisms, cables))
    rng = np.random.default_rng(mechanisms + 10 * cables)
    svgs = []
    with drawing():
        for count in range(6):
            found = []
            for effect in rng.choice(np.array(list(EFFECTS.values()), dtype=object), count, replace=False):
                where = effect.placements(arm)[int(rng.integers(len(effect.placements(arm))))]
                term = effect.terms[0]
                numbers = [Parameter(term.name, 1, 123.456, term.unit, 1.2, True)]
                found.append((Cause(effect, where, np.zeros(len(where.columns)), {}), numbers))
            svgs.append(places_panel(arm, found, some_error(mechanisms), bool(count)).svg)
    page = tmp_path / "page.html"
    page.write_text(f"<!DOCTYPE html><body style='width:560px'>{''.join(svgs)}</body>", encoding="utf-8")
    faults = label_faults(browser_page, page)
    assert not faults, "\n".join(faults)


def test_words_of_an_error() -> None:
    assert error_words(4.712, 0.0504, "°", True) == "4.7° → 0.050°"
    assert error_words(6.25, 0.113, "mm", True) == "6.2 → 0.11 mm"
    assert error_words(6.25, 0.113, "mm", False) == "6.2 mm"
