"""By how much a log's forces are off in the model that is written, on signals made to obey the arm's equations."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.compare import compare
from diagnosis.extended_model import extended_model
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import base_unknowns, linearise
from diagnosis.nuisances import nuisances_at
from identification.signals import Signals
from identification.whitening import Whitener
from mechanism.description import read_neck
from mechanism.tolerance import EXACT
from tests.identification.test_rows import signals
from tests.paths import NECK_FILE

NECK = read_neck(NECK_FILE).model_copy(update={"tolerance": EXACT.model_copy(update={"drum": 0.002})})
"""a drawing that is exact but for its drums, and so for forces"""
K = np.array([9000.0, 7000.0, 8500.0, 6000.0])
NOISE = 1e-3
"""N and N m"""


def logged(too_large: np.ndarray) -> Signals:
    """Motors without friction wind springs; the log says forces that are too large by a share of those that act."""
    s = signals(np.random.default_rng(0), 5000)
    tension = K * s.x
    acting = tension + s.inertial
    load = np.einsum("tij,tj->ti", s.Z, tension)
    return replace(s, f=acting * (1 + too_large), load=load)


def test_forces_that_are_logged_too_large_have_a_gain_above_nothing() -> None:
    """0.4 % at the second motor and -0.2 % at the fourth, of forces that are good to 0.2 %."""
    too_large = np.array([0.0, 0.004, 0.0, -0.002])
    h, late = as_described(NECK), np.zeros(1)
    u = base_unknowns(h, 1)
    p = u.start()
    p[u.slots["fs", None]], p[u.slots["k", None]], p[u.slots["ca", None]] = 0.0, K, 0.0
    at = linearise(h, [logged(too_large)], p, late)
    now = compare(at, (), (), nuisances_at(at), Whitener(np.full((7, 1), 1 / NOISE)))
    stage = FitStage(h, now, (), (), 0.0, now.fit())
    model = extended_model(stage, {})
    gains = {p.index: p.value for p in model.parameters if p.name == "g"}
    assert "actuator_gain" in model.laws
    assert [gains[j] for j in (1, 2, 3, 4)] == pytest.approx(too_large.tolist(), abs=2e-4)
