"""Arms that hide an effect: what their files hold obeys the model, but for the effect, which shows."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, sosfiltfilt

from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import Z
from mechanism.description import read_neck
from mechanism.dynamics import terms
from mechanism.elasticity import elongation
from mechanism.friction import dry
from samples.generator.hidden.experiment import KINDS, hide

Array = NDArray[np.float64]
STEP = 2e-3
FLOOR_N, FLOOR_NM = 0.2, 0.003
"""rms of the motor and of the arm equation in recordings with nothing hidden and 0.1 deg of noise"""


@dataclass(frozen=True)
class Files:
    """What a folder holds, on the log's clock, angles without noise."""

    arm: Arm
    time: Array
    theta: Array
    f: Array
    alpha: Array
    alpha_d: Array
    alpha_dd: Array


def read(folder: Path, name: str = "fitted") -> Files:
    truth = json.loads((folder / "truth.json").read_text())
    angles, log = (np.loadtxt(folder / name / file, delimiter=",", skiprows=1) for file in ("angles.csv", "log.csv"))
    clock = truth["clocks"][name]
    frames = angles[:, 0] + clock["offset_s"] + clock["skew"] * (angles[:, 0] - clock["middle_s"])
    within = (log[:, 0] > frames[0]) & (log[:, 0] < frames[-1])
    seen = make_interp_spline(frames, angles[:, 1:4], k=5)
    time, theta, f = log[within, 0], log[within, 1:5], log[within, 5:9]
    alpha, alpha_d, alpha_dd = (seen.derivative(d)(time) if d else seen(time) for d in range(3))
    return Files(arm_of(read_neck(folder / name / "neck.yaml")), time, theta, f, alpha, alpha_d, alpha_dd)


def residuals(folder: Path, name: str = "fitted", fitted: bool = False) -> tuple[Array, Array]:
    """Of the motor equation, (T, 4), N, and the arm equation, (T, 3), N m, below 8 Hz.

    With the true base parameters, or with k, ca, fs and x0 fitted to the motor equation: what an identification leaves.
    """
    truth, at = json.loads((folder / "truth.json").read_text()), read(folder, name)
    x = elongation(at.arm, at.alpha, at.theta)
    x_d = np.gradient(_below(20, x), STEP, axis=0)
    theta_d = np.gradient(_below(60, at.theta), STEP, axis=0)
    rotor = at.arm.motor_inertia / at.arm.drum * np.gradient(theta_d, STEP, axis=0)
    # f is held for a period from its row on, and acts late
    held = STEP / 2 + truth["delay_s"]
    acting = np.stack([np.interp(at.time - held, at.time, f) for f in at.f.T], axis=-1)
    columns = np.stack([x, x_d, dry(theta_d, truth["sharpness"]), np.ones_like(x)], axis=-1)
    left, columns = _below(8, acting - rotor), _below(8, columns)
    p = np.stack([truth["k"], truth["ca"], truth["fs"], np.zeros(4)])
    if fitted:
        p = np.stack([np.linalg.lstsq(columns[:, j], left[:, j], rcond=None)[0] for j in range(4)], axis=-1)
    tension = sum(columns[..., i] * p[i] for i in (0, 1, 3))
    dynamics = terms(at.arm, at.alpha, at.alpha_d)
    torque = np.einsum("tij,tj->ti", dynamics.M, at.alpha_dd) + dynamics.c + dynamics.g
    pulls = np.einsum("tij,tj->ti", Z(at.arm, at.alpha), tension)
    inner = slice(250, -250)
    return (left - tension - columns[..., 2] * p[2])[inner], _below(8, pulls - torque)[inner]


def _below(hertz: float, values: Array) -> Array:
    return sosfiltfilt(butter(2, hertz, fs=1 / STEP, output="sos"), values, axis=0)


@pytest.fixture(scope="module")
def nothing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("nothing")
    assert hide((), 1, folder, seconds=(10.0, 8.0), cad=0.0, noise_deg=0.0) == ()
    return folder


@pytest.mark.parametrize("name", ["fitted", "held_out"])
def test_without_an_effect_the_model_holds(nothing: Path, name: str) -> None:
    motor, arm = residuals(nothing, name)
    print(motor.std(axis=0), arm.std(axis=0))
    assert np.sqrt(np.mean(motor**2)) < FLOOR_N / 2
    assert np.sqrt(np.mean(arm**2)) < FLOOR_NM / 2


@pytest.mark.parametrize("kind", KINDS)
def test_every_effect_shows(nothing: Path, kind: str, tmp_path: Path) -> None:
    """In one of the equations, twice what noise leaves of it, whatever the seed's model is fitted to."""
    (hidden,) = hide((kind,), 1, tmp_path, seconds=(10.0, 8.0), cad=0.0, noise_deg=0.0)
    assert hidden.effect == kind
    motor, arm = (np.sqrt(np.mean(part**2, axis=0)).max() for part in residuals(tmp_path, fitted=True))
    print(kind, motor, arm)
    assert motor > 2 * FLOOR_N or arm > 2 * FLOOR_NM
