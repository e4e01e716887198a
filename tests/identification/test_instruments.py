"""Elongations that the motors tell: as the laws have them, and nothing of vision's noise, whatever cables remember."""

from dataclasses import replace

import numpy as np
import pytest

from identification.cable_memory import memory_states
from identification.dataset.dataset import DataSet
from identification.estimate_table import as_text
from identification.estimates import estimate
from identification.fitting import _strengthened
from identification.instruments import instrument_signals
from identification.residuals import cable_motion, law_forces
from identification.signals import Signals, signals_of
from identification.unknowns import Unknowns, unknowns
from mechanism.machine import Machine
from tests.identification.test_estimates import CA, FS, K, recording

LAWS = {
    "none": {},
    "cable_creep": {"km": 0.4 * K, "tau": np.array([3.0])},
    "cable_creep that is stiffer than its cable": {"km": 1.5 * K, "tau": np.array([3.0])},
    "cable_hysteresis": {"h": np.full(4, 3.0), "xh": np.array([4e-4])},
    "cable_hysteresis that turns within a hair": {"h": np.full(4, 3.0), "xh": np.array([5e-5])},
    "cable_hardening": {"k2": 0.5 * K, "nh": np.array([3.0])},
}


@pytest.fixture(scope="module")
def data() -> DataSet:
    return recording(2000)


def asked(s: Signals, name: str) -> tuple[Unknowns, np.ndarray]:
    law = name.split(" ")[0]
    u = unknowns(s.arm, ("dry_friction", "linear_cable", *([] if law == "none" else [law])), 1)
    p = u.start()
    for term, value in {"fs": FS, "k": K, "ca": CA, **LAWS[name]}.items():
        p[u.slots[term, None]] = value
    return u, p


def rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


@pytest.mark.parametrize("name", LAWS)
def test_vision_s_noise_has_no_part(name: str, data: DataSet) -> None:
    s = signals_of(data)
    u, p = asked(s, name)
    noise = np.random.default_rng(0).normal(0, 1e-4, s.x.shape)
    other = replace(s, x=s.x + noise, x_d=s.x_d + np.gradient(noise, s.step, axis=0))
    one, two = instrument_signals(s, u, p, 0), instrument_signals(other, u, p, 0)
    assert np.all(rms(two.x - one.x) < 0.01 * rms(noise))
    assert np.all(rms(two.x_d - one.x_d) < 0.01 * rms(other.x_d - s.x_d))


@pytest.mark.parametrize("name", LAWS)
def test_the_laws_pull_as_the_motors_do(name: str, data: DataSet) -> None:
    """But for what differences of rows say wrongly of damping where friction turns over, and what turns within a hair."""
    s = signals_of(data)
    u, p = asked(s, name)
    told = instrument_signals(s, u, p, 0)
    at = cable_motion(told, u.get(p, "x0", 0))
    machine = Machine(s.arm, u.laws, u.values(p))
    pull = machine.pull(at, memory_states(machine, at, s.step))
    drive = law_forces(s, u.laws, u.values(p), u.get(p, "x0", 0), 0.0).drive - s.inertial
    assert np.all(rms(pull - drive) < (0.05 if "hair" in name else 0.01) * rms(drive))


def test_a_combination_that_its_instruments_do_not_follow_is_least_squares_and_the_others_are_not() -> None:
    """Of five columns with errors of their own, instruments have none of these, and tell nothing of one combination."""
    rng = np.random.default_rng(4)
    true, weak = np.array([3.0, -1.0, 2.0, 0.5, 4.0]), np.array([1.0, 1.0, 0.0, -1.0, 0.0]) / np.sqrt(3)
    scale = np.array([1.0, 1e3, 1e-2, 1.0, 10.0])
    signal = rng.standard_normal((2, 4000, 5))
    noise = 0.5 * rng.standard_normal(signal.shape)
    noise -= (noise @ weak)[..., None] * weak  # what instruments do not tell is seen without error
    J = (signal + noise) * scale
    Z = (signal - (signal @ weak)[..., None] * weak + 0.02 * rng.standard_normal(signal.shape)) * scale
    rows = signal @ true + rng.standard_normal(signal.shape[:2])
    free = np.ones(5, dtype=bool)
    (stronger,) = _strengthened([Z], [J], free)

    def estimated(by: np.ndarray) -> np.ndarray:
        return scale * np.linalg.solve(np.einsum("csp,csq->pq", by, J), np.einsum("csp,cs->p", by, rows))

    assert np.abs(estimated(Z) - true).max() > 0.5  # along the combination that has no instrument
    assert np.abs(estimated(J) - true).max() > 0.5  # least squares takes the columns' errors for less of each
    assert np.abs(estimated(stronger) - true).max() < 5 * 1.2 / np.sqrt(len(rows.ravel()))
    (kept,) = _strengthened([signal * scale], [J], free)
    np.testing.assert_allclose(kept, signal * scale, rtol=0, atol=1e-9 * scale.max())


def test_where_instruments_lead_astray_least_squares_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """On an arm whose motors' angles tell little of its cables all numbers ended at the ends of their ranges. Sigma by instruments
    still says how little is told."""
    data = recording(2000)
    true = estimate([data])
    assert not true.solution.is_least_squares
    assert "Durbin-Wu-Hausman" in as_text(true)
    far = "identification.fitting._instrument_estimate"
    monkeypatch.setattr(far, lambda problem, whiten, Zi, p, free: problem.unknowns.low.clip(-1e3))
    found = estimate([data])
    assert found.solution.is_least_squares
    assert np.all(np.diag(found.solution.covariance) > 0.7 * np.diag(true.solution.covariance))
    assert found.as_json()["fit"]["method"] == "least squares at the log's rate"
    assert as_text(found).endswith("numbers are by least squares, which vision's noise may bias")


def test_noise_that_least_squares_takes_for_motion_leads_nobody_astray() -> None:
    """Cables so stiff that vision hardly sees them stretch: least squares leaves less, with a fraction of their stiffness."""
    stiff = 10 * K
    found = estimate([recording(2000, stiffness=stiff)])
    assert not found.solution.is_least_squares
    value, sigma = (
        np.array([getattr(p, name) for p in found.parameters if p.name == "k"]) for name in ("value", "sigma")
    )
    by_least_squares = found.solution.least_squares[found.unknowns.slots["k", None]]
    assert np.all(by_least_squares < 0.6 * stiff)
    assert np.all(np.abs(value - stiff) < 4 * sigma)
