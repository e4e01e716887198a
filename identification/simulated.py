"""The recorded forces through the model, beside what was measured."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset import DataSet
from identification.model import Model, machine_of
from identification.series import Series, numbered
from mechanism.simulation import State, simulate
from xneck.errors import Refused

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Simulated:
    """Simulated and measured series on the same times, and the error of each channel."""

    series: Series
    """columns alphaI, thetaJ, tensionJ as simulated and alphaI_measured, thetaJ_measured"""
    rms: dict[str, float]
    """RMS of simulated less measured, by channel; rad"""
    window_s: float


def simulate_recording(
    data: DataSet,
    model: Model,
    window_s: float | None = None,
    progress: Callable[[int], object] = lambda samples: None,
) -> Simulated:
    """Free-running from the first sample, or restarted from the measured state every `window_s` seconds.

    Windows run as one batch; `progress` is told of every sample of a window. Raises Refused where the recording is
    shorter than a window.
    """
    machine = machine_of(model, data.arm)
    s = data.state
    step = float(np.mean(np.diff(s.time)))
    samples = len(s) if window_s is None else round(window_s / step)
    if samples < 2 or samples > len(s):
        raise Refused("simulate", f"a window of {window_s} s does not fit {len(s) * step:.1f} s of data")
    windows = len(s) // samples
    kept = windows * samples

    def cut(values: Array) -> Array:
        return values[:kept].reshape(windows, samples, -1)

    alpha, alpha_d = cut(s.matrix("alpha")), cut(s.matrix("alpha", "_d"))
    theta, theta_d, f = cut(s.matrix("theta")), cut(s.matrix("theta", "_d")), cut(s.matrix("f"))
    start = State(alpha[:, 0], alpha_d[:, 0], theta[:, 0], theta_d[:, 0])
    motion = simulate(machine, start, step * np.arange(samples, dtype=float), f, progress=progress)
    columns: dict[str, Array] = {}
    rms: dict[str, float] = {}
    for stem, found, measured in (("alpha", motion.alpha, alpha), ("theta", motion.theta, theta)):
        flat, truth = found.reshape(kept, -1), measured.reshape(kept, -1)
        columns |= numbered(stem, flat) | numbered(stem, truth, "_measured")
        rms |= {f"{stem}{i + 1}": float(r) for i, r in enumerate(np.sqrt(np.mean((flat - truth) ** 2, axis=0)))}
    columns |= numbered("tension", motion.tension.reshape(kept, -1))
    return Simulated(Series(s.time[:kept], columns), rms, samples * step)
