"""The clock between camera and log, on motions made by MuJoCo, exact tangents and motors of their own."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification.series import Series
from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from vision.angles import Angles
from vision.clock import Clock, fit_clock
from vision.encoder_log import read_log, uniform
from xneck.errors import Refused

SAMPLES = Path(__file__).parents[2] / "samples"
NECK = read_neck(SAMPLES / "recording/neck.yaml")
ARM = arm_of(NECK)
NOISE = np.radians(0.1)


def truth() -> dict[str, float]:
    return json.loads((SAMPLES / "truth.json").read_text())["recording"]


def seen(seed: int, noise: float = NOISE) -> Angles:
    stored = np.load(SAMPLES / "truth.npz")
    alpha = stored["recording_frame_alpha"]
    noisy = alpha + np.random.default_rng(seed).normal(0, noise, alpha.shape)
    return Angles(stored["recording_frame_times"], noisy, np.full(alpha.shape, noise))


@pytest.fixture(scope="module")
def log() -> Series:
    return uniform(read_log(SAMPLES / "recording/log.mcap", NECK))


def offset_error(clock: Clock) -> float:
    t = truth()
    return clock.offset - (t["offset_s"] + t["skew"] * (clock.middle - t["middle_s"]))


def test_offset_and_skew_are_found_with_an_honest_sigma(log: Series) -> None:
    """20 seeds of camera noise: every offset within 0.5 ms (a quarter of what is asked), z of offset and skew below 3."""
    clocks = [fit_clock(ARM, seen(seed), log) for seed in range(20)]
    errors = np.array([offset_error(c) for c in clocks])
    assert np.max(np.abs(errors)) < 0.5e-3
    assert np.max(np.abs(errors / [c.offset_sigma for c in clocks])) < 3
    skew = np.array([(c.skew - truth()["skew"]) / c.skew_sigma for c in clocks])
    assert np.max(np.abs(skew)) < 3


def test_frames_and_angles_that_are_missing_do_not_move_the_clock(log: Series) -> None:
    angles = seen(1)
    alpha = angles.alpha.copy()
    alpha[100:130] = np.nan
    alpha[::7, 1] = np.nan
    assert abs(offset_error(fit_clock(ARM, replace(angles, alpha=alpha), log))) < 0.5e-3


def swapped(log: Series, a: str, b: str) -> Series:
    columns = dict(log.columns)
    columns[a], columns[b] = columns[b], columns[a]
    return Series(log.time, columns)


def turned(log: Series, name: str) -> Series:
    return Series(log.time, {**log.columns, name: -log.columns[name]})


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda log: turned(log, "theta2"), r"theta2.*theta_sign"),
        (lambda log: swapped(log, "theta1", "theta3"), "theta1|theta3"),
        (lambda log: swapped(log, "theta4", "f4"), "theta4|columns"),
        (lambda log: Series(log.time[:2000], {k: v[:2000] * 0 for k, v in log.columns.items()}), "stand still"),
    ],
)
def test_a_log_with_columns_or_signs_exchanged_is_refused_by_name(log: Series, change, word: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(Refused, match=word):
        fit_clock(ARM, seen(0), change(log))


def test_a_log_of_another_time_is_refused(log: Series) -> None:
    """The sample's log before the video begins is at rest, and another recording's log shows another motion."""
    other = uniform(read_log(SAMPLES / "held_out/log.mcap", NECK))
    with pytest.raises(Refused, match=r"same motion|overlap"):
        fit_clock(ARM, seen(0), other)


def test_an_arm_at_rest_and_a_periodic_motion_are_refused(log: Series) -> None:
    angles = seen(0)
    with pytest.raises(Refused, match="move by"):
        fit_clock(ARM, replace(angles, alpha=angles.alpha * 0 + 0.1), log)
    with pytest.raises(Refused, match="repeats itself"):
        fit_clock(ARM, *periodic(ARM))


def periodic(arm: Arm) -> tuple[Angles, Series]:
    """A sinusoid of 1 Hz on rigid cables: any whole second fits."""
    t, T = np.arange(600, dtype=float) / 30, 0.002 * np.arange(12_000, dtype=float) - 2

    def alpha(t: np.ndarray) -> np.ndarray:
        return np.column_stack([0.3 * np.sin(2 * np.pi * t + p) for p in (0.0, 1.0, 2.0)])

    theta = -(lengths(arm, alpha(T)) - lengths(arm, np.zeros(3))) / arm.drum
    columns = {f"theta{j + 1}": theta[:, j] for j in range(4)} | {f"f{j + 1}": np.full(len(T), 40.0) for j in range(4)}
    return Angles(t, alpha(t), np.full((len(t), 3), NOISE)), Series(T, columns)
