"""A designed motion shows effects and tells look-alikes apart, within its limits, about as well as is said of it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from diagnosis.cause_fit import CauseFitter
from diagnosis.compare import compare
from diagnosis.deciding_motion import DecidingMotion, motion_for
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import as_described
from diagnosis.motion_questions import effects_among, questions_about
from diagnosis.noise_ensemble import noise_ensemble
from diagnosis.nuisances import nuisances_at
from diagnosis.planned_motion import MotionJudge, Question, loss_alone, motion_judge
from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series, numbered_columns
from identification.design.fourier import random_shape, tone_frequencies
from identification.design.information import AngleNoise
from identification.design.search import SearchOptions
from identification.design.trajectory import MotionLimits, Trajectory, trajectory
from identification.estimates import DEFAULT_LAWS
from mechanism.arm import arm_of
from mechanism.machine import Machine
from samples.generator import prescribed
from samples.generator.laws import dry_and_viscous, linear
from samples.generator.motion import Motion
from samples.generator.prescribed import World
from synchronisation.angles import Angles
from synchronisation.synchronise import synchronise
from tests.identification.test_estimates import CA, FILE, FS, NECK, K
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import parse_yaml

LIMITS = MotionLimits(np.radians(30), 200.0, (20.0, 112.0), 130.0)
NOISE = AngleNoise(np.radians(0.05), 30.0)
SECONDS = 20.0
VALUES = {"fs": FS, "cm": np.array([0.5]), "fv": np.zeros(4), "k": K, "ca": CA}
MACHINE = Machine(arm_of(NECK), DEFAULT_LAWS, VALUES)
ALIKE = ("actuator_gain", "drum_radius")
"""a motor that pulls too much, and a drum that is too thin"""
SHOWN = (
    "actuator_gain",
    "actuator_offset",
    "drum_radius",
    "pulley_friction",
    "tip_payload",
    "base_tilt",
    "cable_creep",
)


def questions(*names: str) -> tuple[Question, ...]:
    return questions_about([EFFECTS[name] for name in names], NECK)


@cache
def designed() -> DecidingMotion:
    return motion_for(NECK, MACHINE, questions(*ALIKE), (), LIMITS, NOISE, SearchOptions(SECONDS, draws=4, changes=4))


def small_motion() -> Trajectory:
    """As careful people move an arm: slowly, a little, under all but one tension."""
    limits = replace(LIMITS, peak=np.radians(8), speed=30.0, tension=(35.0, 55.0))
    shape = random_shape(tone_frequencies(4, SECONDS, (0.1, 0.9)), np.random.default_rng(3))
    return trajectory(MACHINE, shape, limits, SECONDS, 50.0)


def judge(*names: str) -> MotionJudge:
    return motion_judge(NECK, MACHINE, questions(*names), NOISE)


def test_it_tells_look_alikes_better_than_a_small_motion() -> None:
    small = {(a.question.effect.name, a.question.beside): a for a in judge(*ALIKE).answers(small_motion())}
    assert len(small) == len(designed().answers) == 4
    for a in designed().answers:
        before = small[a.question.effect.name, a.question.beside]
        assert a.ratio > 1
        assert a.loss > 1.5 * before.loss  # of a gain no motion tells more than how well forces are known


def test_limits_hold() -> None:
    motion = designed().designed.motion
    assert np.abs(motion.alpha).max() <= LIMITS.peak
    assert np.abs(motion.theta_d).max() <= LIMITS.speed
    assert LIMITS.tension[0] < motion.tension.min()
    assert motion.tension.max() < LIMITS.tension[1]
    assert np.abs(motion.f).max() <= LIMITS.force


def test_what_stands_in_its_place_takes_a_part_of_an_effect() -> None:
    for name, other in (ALIKE, ALIKE[::-1]):
        shown, told = (
            next(a for a in designed().answers if a.question.effect.name == name and a.question.beside is beside)
            for beside in (None, EFFECTS[other])
        )
        assert 0 < told.loss < shown.loss


def test_an_effect_that_is_all_another_one_does_is_not_told_from_it() -> None:
    """A negative control: an effect beside itself leaves nothing."""
    gain = EFFECTS["actuator_gain"]
    alike = replace(questions("actuator_gain")[0], beside=gain)
    (answer,) = motion_judge(NECK, MACHINE, [alike], NOISE).answers(small_motion())
    assert answer.ratio < 1e-3


def test_predicted_losses_are_those_of_a_recording_of_the_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    """The generator makes the motion by other geometry and integration. What each effect leaves in a diagnosis of the
    synchronised recording is what is said of it beforehand, within a factor of two."""
    data = recorded(designed().designed.motion, monkeypatch)
    fitter = CauseFitter(as_described(NECK), [noise_ensemble(data, frame_angles(data), 0)])
    at = fitter.base_model().comparison.linearisation
    asked = [q for q in questions(*SHOWN) if q.beside is None]
    choices = [(q.effect, q.suspects[0].shape) for q in asked]
    real = compare(at, (), choices, nuisances_at(at), fitter.whiten, clock_relaxed=True).with_zero_residual()
    planned = motion_judge(NECK, MACHINE, asked, NOISE).comparison(designed().designed.motion).with_zero_residual()
    ratios = {q.effect.name: loss_alone(planned, q.suspects[0]) / loss_alone(real, q.suspects[0]) for q in asked}
    assert all(0.5 < ratio < 2 for ratio in ratios.values()), ratios


def recorded(motion: Trajectory, monkeypatch: pytest.MonkeyPatch) -> DataSet:
    as_planned = Motion(motion.time, motion.alpha, motion.tension)
    monkeypatch.setattr(prescribed, "exciting", lambda *_: as_planned)
    world = World(parse_yaml(FILE.read_text(), str(FILE)), linear(K, CA), dry_and_viscous(FS, np.zeros(4)))
    made = prescribed.prescribe(world, SECONDS - 0.5, 4002)
    alpha = made.frame_alpha + np.random.default_rng([4002, 5]).normal(0, NOISE.sigma, made.frame_alpha.shape)
    log = Series(made.log_time, numbered_columns("theta", made.counted) | numbered_columns("f", made.f))
    return synchronise(NECK, "", Angles(made.frame_times, alpha, np.full(alpha.shape, NOISE.sigma)), log, {})


def test_unknown_names_are_refused_with_those_that_are_valid() -> None:
    effects, parameters = effects_among(["base_tilt", "k"])
    assert [e.name for e in effects] == ["base_tilt"]
    assert parameters == ["k"]
    with pytest.raises(Refused, match=r"unknown effect or parameter 'base_tilts'; did you mean base_tilt\?"):
        effects_among(["base_tilts"])
    with pytest.raises(
        Refused, match=r"unknown effect or parameter 'rust'; valid: cable_hardening, presliding_friction, .*more"
    ):
        effects_among(["rust"])


def test_a_model_without_the_base_laws_is_refused_in_one_line() -> None:
    values = {**VALUES, "E": np.full(4, 3e9), "c": np.zeros(4)}
    other = Machine(MACHINE.arm, ("dry_friction", "youngs_modulus"), values)
    with pytest.raises(Refused, match=r"beside the law linear_cable.*leave --model out") as refused:
        motion_judge(NECK, other, questions("base_tilt"), NOISE)
    assert "\n" not in str(refused.value)
