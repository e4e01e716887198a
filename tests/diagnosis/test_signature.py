"""What is wrong is described as it was hidden, and noise is not described at all.

The motion and the base model's columns are a recording's; what is left of it is made here, filtered as residuals are.
"""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.compare import compare
from diagnosis.explained_energy import Autocovariance, autocovariance, explained_energy
from diagnosis.fit_stage import FitStage
from diagnosis.hypothesis import as_described
from diagnosis.linearisation import (
    Linearisation,
    RecordingLinearisation,
    base_unknowns,
    corrected_signals,
    linearise,
)
from diagnosis.noise_ensemble import noise_whitener
from diagnosis.nuisances import Nuisances, nuisances_at
from diagnosis.residual_conditions import ALONG, conditions
from diagnosis.signature import Signature, signature
from diagnosis.signature_record import words
from identification.fitting import segment_starts
from identification.residuals import ResidualRows
from tests.identification.test_estimates import CA, FS, K, recording

FLOOR = np.array([0.3, 0.3, 0.3, 0.3, 1e-3, 1e-3, 1e-3])


@pytest.fixture(scope="module")
def at() -> Linearisation:
    data = recording(2000)
    h = as_described(data.neck)
    u, late = base_unknowns(h, 1), np.zeros(1)
    p = u.start()
    for name, value in {"fs": FS, "k": K, "ca": CA}.items():
        p[u.slots[name, None]] = value
    return linearise(h, corrected_signals(h, [data], late), p, late)


@pytest.fixture(scope="module")
def known(at: Linearisation) -> Nuisances:
    return nuisances_at(at)


def noise(place: RecordingLinearisation, rng: np.random.Generator) -> np.ndarray:
    """As vision's: white at the log's rate, filtered; (C, S)."""
    drawn = place.signals.low_pass(rng.normal(size=(len(FLOOR), len(place.signals.time))))
    return FLOOR[:, None] * drawn / drawn.std()


def described(
    at: Linearisation, known: Nuisances, seed: int, more: np.ndarray | float, louder: float = 1.0
) -> Signature:
    """Of noise, `louder` than it is known to be, with something more in it."""
    rng = np.random.default_rng(seed)
    (place,) = at.recordings
    drawn = [noise(place, rng) for _ in range(4)]
    rows = ResidualRows(louder * noise(place, rng) + more, place.rows.jacobian)
    there = replace(at, recordings=(replace(place, rows=rows),))
    whiten = noise_whitener([drawn], [segment_starts(place.signals)], place.signals.arm.M)
    now = compare(there, (), (), known, whiten)
    turn = FitStage(now.linearisation.hypothesis, now, (), (drawn,), 0.0, now.fit())
    return signature(turn, turn)


def test_chance_is_as_rare_as_it_is_said_to_be(at: Linearisation) -> None:
    """One in twenty of 400 draws of noise for each condition; taken for white, noise would look like a pattern far more often."""
    (place,) = at.recordings
    rng = np.random.default_rng(0)
    draws, level, alarms, white = 400, 0.05, 0, 0
    rows = [place.signals.low_pass.kept // place.signals.low_pass.factor]
    rows = [rows[0] - rows[0][0]]
    every = [(c, condition.columns()) for c in (0, 5) for condition in conditions(at.recordings, c)]
    none = np.zeros((len(rows[0]), 0))
    # slow noise, of a second: what models leave is no faster
    slow = np.exp(-0.5 * (np.arange(-96, 97) / 16) ** 2)
    for _ in range(draws):
        r = [np.convolve(rng.normal(size=len(rows[0]) + len(slow) - 1), slow, mode="valid")]
        own = autocovariance(r, rows)
        flat = Autocovariance(own.grid_rows, own.lags * (np.arange(len(own.lags)) == 0))
        for _, columns in every:
            alarms += explained_energy(r, columns, none, own).log_p < np.log(level)
            white += explained_energy(r, columns, none, flat).log_p < np.log(level)
    count = draws * len(every)
    # draws are independent, conditions of one draw need not be: the sigma of their mean is that of one condition at most
    assert alarms / count < level + 3 * np.sqrt(level * (1 - level) / draws)
    assert white / count > 5 * level


@pytest.mark.parametrize("seed", range(4))
def test_noise_has_no_signature(seed: int, at: Linearisation, known: Nuisances) -> None:
    found = described(at, known, seed, 0.0)
    assert found.kind == "nothing"
    assert found.clear == ()
    assert words(found, 4) == "nothing stands above noise"


@pytest.mark.parametrize("seed", range(4))
def test_louder_noise_that_follows_nothing_is_unclear(seed: int, at: Linearisation, known: Nuisances) -> None:
    """One in a hundred would be a pattern by chance."""
    found = described(at, known, 10 + seed, 0.0, louder=3.0)
    assert found.kind == "unclear"
    assert len(found.channels) == len(FLOOR)


@pytest.mark.parametrize("teeth", [3, 7, 25])
def test_teeth_are_counted(teeth: int, at: Linearisation, known: Nuisances) -> None:
    """To a part of what the drum's way of half a turn could tell apart; few are what the base model's numbers make something of."""
    (place,) = at.recordings
    s, R = place.signals, place.hypothesis.neck.motors[1].R
    more = np.zeros_like(place.rows.residual)
    more[1] = s.low_pass(2.0 * np.sin(teeth * s.theta[:, 1] / R + 0.3))
    found = described(at, known, 20, more)
    assert found.kind == "periodic"
    assert found.channels == (1,)
    (p,) = found.shown
    assert p.drum_wave is not None
    assert abs(p.drum_wave.order - teeth) < 4 * p.drum_wave.sigma < 0.5
    assert abs(p.drum_wave.order / teeth - 1) < (0.01 if teeth > 5 else 0.03)
    assert found.best is p


def test_friction_that_rises_is_a_drift_along_the_motion(at: Linearisation, known: Nuisances) -> None:
    (place,) = at.recordings
    s = place.signals
    more = np.zeros_like(place.rows.residual)
    age = (s.time - s.time[0]) / (s.time[-1] - s.time[0])
    more[2] = s.low_pass(-4.0 * age * np.sign(s.theta_d[:, 2]))
    found = described(at, known, 21, more)
    assert found.kind == "drift"
    assert found.channels == (2,)
    assert found.best.against == "time" + ALONG
    # what rubs more leaves less than the model says
    assert found.best.before[0] > 0 > found.best.before[-1]


def test_pushes_are_episodes_where_they_were(at: Linearisation, known: Nuisances) -> None:
    (place,) = at.recordings
    s = place.signals
    time = s.time - s.time[0]
    push = sum(np.exp(-0.5 * ((time - t) / 0.15) ** 2) for t in (6.0, 14.0, 22.0))
    more = np.zeros_like(place.rows.residual)
    more[4:] = 0.1 * s.low_pass(np.asarray(push))
    found = described(at, known, 22, more)
    assert found.kind == "episodes"
    assert found.channels == (4, 5, 6)
    # numbers of the base model bend under a push and err a little elsewhere too
    for t in (6.0, 14.0, 22.0):
        assert any(e.begin - 0.5 < t < e.end + 0.5 for e in found.episodes)
    assert sum(e.end - e.begin for e in found.episodes) < 0.3 * (time[-1] - time[0])


def test_a_trace_of_what_is_wrong_elsewhere_is_not_what_is_wrong(at: Linearisation, known: Nuisances) -> None:
    """Joint 3 far above noise in no pattern, and joint 1 a little, by the lean of the tip: that is said of joint 1 alone."""
    (place,) = at.recordings
    s = place.signals
    more = np.zeros_like(place.rows.residual)
    more[4] = 3e-3 * s.low_pass(np.sin(4 * s.alpha.sum(axis=1)))
    alone = described(at, known, 23, more)
    assert (alone.kind, alone.channels) == ("lean of the tip", (4,))
    more[6] = 40 * noise(place, np.random.default_rng(24))[6]
    beside = described(at, known, 23, more)
    assert (beside.kind, beside.channels) == ("unclear", (6,))
    assert "joint 3" in words(beside, 4)
