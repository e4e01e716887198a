"""The observer as a C99 file: compiled by the machine's compiler, it gives the same numbers as Python."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from observation.c_source import c_source
from observation.observer import Observer
from tests.observation.arms import case, with_laws

COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
SEED = 5010
EXTENDED = (
    "cable_creep",
    "cable_hysteresis",
    "cable_hardening",
    "joint_friction",
    "stribeck_friction",
    "pulley_friction",
)
NUMBERS = {"km": 800.0, "tau": 2.0, "h": 2.0, "xh": 2e-4, "k2": 2e5, "nh": 3.0, "cj": 0.004, "dj": 0.001, "vj": 0.05,
           "nj": 2.0, "fst": 2.0, "vs": 8.0, "ns": 2.0,
           "mu": 0.004, "ma": 0.004, "vp": 1e-3, "wm": 0.3, "taul": 4e-3, "g": 0.02, "fo": 0.5,
           "play": 3e-4, "pb": 0.5}  # fmt: skip


def pointer(values: np.ndarray) -> "ctypes._Pointer[ctypes.c_double]":
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


@pytest.mark.skipif(COMPILER is None, reason="no C compiler on this machine")
@pytest.mark.parametrize(
    "laws",
    [(), EXTENDED, ("actuator_lag", "actuator_gain", "actuator_offset"), ("backlash",)],
    ids=["base", "extended", "actuators", "play"],
)
def test_c_and_python_agree(tmp_path: Path, laws: tuple[str, ...]) -> None:
    of = with_laws(case(SEED), laws, NUMBERS)
    assert of.model.pose is not None
    left = of.model.pose.residual.model_copy(update={"rate_rad_s": (0.01, 0.02, 0.0), "slope": (0.01, 0.0, 0.02)})
    model = of.model.model_copy(update={"pose": of.model.pose.model_copy(update={"residual": left})})
    observer = Observer(of.neck, model)
    file = tmp_path / "observer.c"
    file.write_text(c_source(observer))
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-shared", "-fPIC"]
    library = tmp_path / "observer.so"
    subprocess.run([str(COMPILER), *flags, str(file), "-o", str(library), "-lm"], check=True)
    c = ctypes.CDLL(str(library))
    memory = (ctypes.c_double * 10_000)()
    c.xneck_observer_begin(memory, None)
    alpha, alpha_d, covariance = np.zeros(3), np.zeros(3), np.zeros((6, 6))
    theta, f = np.ascontiguousarray(of.log.matrix("theta")), np.ascontiguousarray(of.log.matrix("f"))
    time = 2e-3 * np.arange(400.0)
    time[200:] += 0.011  # rows that are missing
    time[300:] += 0.2  # a gap
    sigma = np.full(3, 1e-3)
    for row in range(400):
        angles = of.alpha[row].copy() if row % 50 == 49 else None
        if angles is not None:
            angles[1] = np.nan
        seen = observer.step(theta[row], f[row], float(time[row]), angles, sigma if angles is not None else None)
        interval = time[row] - time[row - 1] if row else 0.0
        c.xneck_observer_step(memory, ctypes.c_double(interval), pointer(theta[row].copy()), pointer(f[row].copy()))
        if angles is not None:
            c.xneck_observer_frame(memory, pointer(angles), pointer(sigma))
        c.xneck_observer_read(memory, pointer(alpha), pointer(alpha_d), pointer(covariance))
        np.testing.assert_allclose(alpha, seen[0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(alpha_d, seen[1], rtol=0, atol=1e-9)
        np.testing.assert_allclose(covariance, seen[2], rtol=1e-7, atol=1e-12)
