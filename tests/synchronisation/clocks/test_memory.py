"""Clocks of cables that stretch otherwise as tension falls, and of drums that lag behind their motors: by other code's elements."""

from typing import Any

import numpy as np
import pytest
import yaml

from identification.dataset.series import Series, numbered_columns
from mechanism.arm import arm_of
from mechanism.description import Neck
from samples.forward_arms import Settings, make_arms
from samples.forward_arms.drawing import neck as neck_of
from samples.generator.laws import dry_and_viscous, maxwell_slip
from samples.generator.prescribed import World
from samples.worlds import clock_worlds
from samples.worlds.clock_worlds import NECK_FILE, arm, clock_recording
from synchronisation.angles import Angles
from synchronisation.clocks import fine_alignment
from synchronisation.clocks.cable_equation import play_lag
from synchronisation.clocks.clock import fit_clock
from tests.observation.test_play import Gap
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.strict_yaml import validate_document

SLIP_M = np.repeat([[0.4e-3], [1e-3], [2e-3]], 4, axis=1)
"""m: travel after which each of three elements of a cable slips, at a third of 4 N"""
PLAY_M, PLAYING_SEED = 4e-4, 5013


def looped(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, float, Any]:
    """What `fit_clock` takes of an arm all of whose cables have fibres that stick and slip, and its clock's offset and skew."""
    k, fs, ca = np.array([9000.0, 7000.0, 8500.0, 6000.0]), np.array([12.0, 19.0, 15.0, 17.0]), np.full(4, 80.0)
    stretch = maxwell_slip(k, ca, 4.0 / 3 / SLIP_M, SLIP_M)
    world = World(yaml.safe_load(NECK_FILE.read_text()), stretch=stretch, friction=dry_and_viscous(fs, np.zeros(4)))
    monkeypatch.setattr(clock_worlds, "_world", lambda *_: (world, np.zeros(4)))
    made = clock_recording("linear elastic", 101, 30.0)
    clocks = made.clocks
    return (arm(), made.angles, made.log), clocks.offset_s - clocks.skew * clocks.middle_s, clocks.skew


def loose(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, float, Any]:
    """The same of an arm whose motors all go on by a play before their drums follow, integrated forward."""
    settings = Settings(seconds=20.0, noise_deg=0.02, step=2e-3, base="exact", counts=65536)
    one = next(iter(make_arms([PLAYING_SEED], settings, hidden=[(Gap(PLAY_M, 1.0, np.zeros(())),)])))
    recording, film = one.recordings[1], one.recordings[1].film
    angles = Angles(film.stamp, film.seen, np.full_like(film.seen, film.noise))
    log = Series(recording.time, numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f))
    neck = validate_document(neck_of(one.drawing), Neck, "neck.yaml")
    return (arm_of(neck), angles, log), film.offset, film.skew


@pytest.mark.parametrize("remembering", [looped, loose])
def test_the_clock_stands_where_cables_or_drums_remember(remembering: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within 3.3 sigma, a chance of one in a thousand, and nearer than without memory, which half a millisecond moves."""
    seen, offset, skew = remembering(monkeypatch)
    fitted = one_blas_thread(fit_clock)
    found = fitted(*seen)
    monkeypatch.setattr(fine_alignment, "MAX_MEMORY_MISFIT", 0.0)
    forgetful = fitted(*seen)
    error, error_without = (abs(clock.offset - (offset + skew * clock.middle)) for clock in (found, forgetful))
    assert error < 3.3 * found.offset_sigma
    assert found.offset_sigma < 5e-4
    assert error_without > 5e-4
    assert error < error_without / 2


def test_a_play_lags_by_half_its_width_after_turning() -> None:
    there_and_back = np.concatenate([np.linspace(0, 5, 51), np.linspace(5, 0, 51)])[:, None]
    lag = play_lag(there_and_back, np.array([2.0]))[:, 0, 0]
    assert lag[5] == pytest.approx(-0.5)  # half of it is still to be crossed
    assert lag[[20, 50]] == pytest.approx([-1.0, -1.0])
    assert lag[61] == pytest.approx(0.0)
    assert lag[[80, 101]] == pytest.approx([1.0, 1.0])
