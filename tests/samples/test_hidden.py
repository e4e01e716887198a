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
from samples.generator.hidden.experiment import KINDS, MANNERS, RECORDINGS, hide

Array = NDArray[np.float64]
STEP = 2e-3
SECONDS, SHORT = (8.0, 5.0), (5.0, 5.0)
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
    return Files(
        arm=arm_of(read_neck(folder / name / "neck.yaml")),
        time=time,
        theta=theta,
        f=f,
        alpha=alpha,
        alpha_d=alpha_d,
        alpha_dd=alpha_dd,
    )


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
    assert hide((), 1, folder, seconds=SECONDS, cad=0.0, noise_deg=0.0) == ()
    return folder


@pytest.mark.parametrize("name", ["fitted", "held_out"])
def test_without_an_effect_the_model_holds(nothing: Path, name: str) -> None:
    motor, arm = residuals(nothing, name)
    assert np.sqrt(np.mean(motor**2)) < FLOOR_N / 2
    assert np.sqrt(np.mean(arm**2)) < FLOOR_NM / 2


@pytest.mark.parametrize("kind", KINDS)
def test_every_effect_shows(nothing: Path, kind: str, tmp_path: Path) -> None:
    """In one of the equations, twice what noise leaves of it, whatever Fasquelle's model is fitted to."""
    (hidden,) = hide((kind,), 1, tmp_path, seconds=SECONDS, cad=0.0, noise_deg=0.0)
    assert hidden.effect == kind
    motor, arm = (np.sqrt(np.mean(part**2, axis=0)).max() for part in residuals(tmp_path, fitted=True))
    assert motor > 2 * FLOOR_N or arm > 2 * FLOOR_NM


@pytest.mark.parametrize("kind", KINDS)
def test_an_effect_of_no_size_is_none(nothing: Path, kind: str, tmp_path: Path) -> None:
    hide((kind,), 1, tmp_path, seconds=SHORT, cad=0.0, noise_deg=0.0, size=0.0)
    none, this = (read(folder, "held_out") for folder in (nothing, tmp_path))
    count = 2 * np.pi / 2048  # one, where angles are rounded the other way
    np.testing.assert_allclose(this.theta, none.theta, atol=1.01 * count)
    np.testing.assert_allclose(this.f, none.f, atol=0.0101)
    np.testing.assert_allclose(this.alpha, none.alpha, atol=1e-5)


def test_a_seed_gives_the_same_files_and_another_seed_another_arm(tmp_path: Path) -> None:
    kinds = ("pulley_radius", "warming_friction")
    first, again, other = (hide(kinds, seed, tmp_path / str(i), seconds=SHORT) for i, seed in enumerate((5, 5, 6)))
    assert first == again != other
    assert [h.effect for h in first] == ["warming_friction", "pulley_radius"]
    files = sorted(path.relative_to(tmp_path / "0") for path in (tmp_path / "0").rglob("*.*"))
    assert len(files) == 9
    for file in files:
        texts = [(tmp_path / str(i) / file).read_text() for i in range(3)]
        assert texts[0] == texts[1]
        assert (texts[0] == texts[2]) == (file.name == "recording.yaml")


def test_a_name_that_nothing_has_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="gremlins is none of warming_friction"):
        hide(("gremlins",), 1, tmp_path)
    with pytest.raises(ValueError, match="wild is none of rich"):
        hide((), 1, tmp_path, manner="wild")


def test_both_recordings_hide_the_same_in_other_motions(tmp_path: Path) -> None:
    hide((), 2, tmp_path, seconds=SHORT)
    fitted, held_out = (read(tmp_path, name) for name in RECORDINGS)
    assert (tmp_path / "fitted/neck.yaml").read_text() == (tmp_path / "held_out/neck.yaml").read_text()
    rows = slice(0, 2500)
    assert abs(np.corrcoef(fitted.alpha[rows, 0], held_out.alpha[rows, 0])[0, 1]) < 0.9


def test_the_engineer_is_wrong_by_no_more_than_said(tmp_path: Path) -> None:
    hide((), 3, tmp_path, seconds=SHORT, cad=0.01)
    said = read_neck(tmp_path / "fitted/neck.yaml").model_dump()
    true = json.loads((tmp_path / "truth.json").read_text())["neck"]
    for group, keys in (("mechanisms", ("L", "b", "r")), ("motors", ("Ia", "rd")), ("cables", ("x0",))):
        for is_said, is_true in zip(said[group], true[group], strict=True):
            for key in keys:
                off = abs(is_said[key] / is_true[key] - 1)
                assert 0 < off < 0.01 * {"rd": 0.2, "x0": 10}.get(key, 1), key


@pytest.mark.parametrize("manner", MANNERS)
def test_three_effects_go_together_in_every_manner(manner: str, tmp_path: Path) -> None:
    """The effects are those that each would have alone."""
    kinds = ("cable_creep", "cable_hardening", "actuator_gain")
    together = hide(kinds, 4, tmp_path / "all", seconds=SHORT, manner=manner)
    assert [h.effect for h in together] == ["cable_hardening", "cable_creep", "actuator_gain"]
    alone = hide(kinds[2:], 4, tmp_path / "one", seconds=SHORT, manner=manner)
    assert alone == together[2:]


def test_a_slack_cable_hangs_and_the_others_carry_the_arm(tmp_path: Path) -> None:
    """Its elongation goes below zero with nothing but friction in its force, and the arm equation holds as ever."""
    (hidden,) = hide(("cable_slack",), 1, tmp_path, seconds=(20.0, 8.0), cad=0.0, noise_deg=0.0)
    j, at = int(hidden.where[-1]) - 1, read(tmp_path)
    x = elongation(at.arm, at.alpha, at.theta)
    loose = x[:, j] < -0.1e-3
    assert loose.sum() * STEP > 0.5
    assert hidden.parameters["depth"] * 0.98 < -x[:, j].min() < hidden.parameters["depth"] * 1.02
    assert np.delete(x, j, axis=1).min() > 0
    truth = json.loads((tmp_path / "truth.json").read_text())
    pulls = np.einsum("tij,tj->ti", Z(at.arm, at.alpha), np.maximum(truth["k"] * x, 0))
    dynamics = terms(at.arm, at.alpha, at.alpha_d)
    torque = np.einsum("tij,tj->ti", dynamics.M, at.alpha_dd) + dynamics.c + dynamics.g
    assert np.std((pulls - torque)[loose]) < 0.05 * np.std(torque), "but for dampers"
