"""Whether the arm is still the one identified: what its motors' laws leave unsaid, against what they left when it was calibrated.

The observer's friction error is the force by which a motor's equation misses its command. Over a window it is held against the
sigma that calibration left: its mean (a pre-elongation that moved, a load), its part along the motor's direction (friction that
changed), and its rms (anything). Windows follow each other; the first that is beyond a limit says from when on.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.friction import dry
from observation.load_test import FoundLoad

Array = NDArray[np.float64]

WINDOW_S = 8.0
"""s: some turns of every motor in lively motion (docs/thresholds.md)"""
SETTLING_S = 2.0
"""s after a begin that are not judged: the observer finds its state first (docs/thresholds.md)"""
MAX_MEAN_RATIO = 0.6
"""mean of a motor's unsaid force over a window, in sigmas of calibration (docs/thresholds.md)"""
MAX_ALONG_RATIO = 0.9
"""its part along the motor's direction, in those sigmas (docs/thresholds.md)"""
MAX_RMS_RATIO = 1.5
"""its rms, in those sigmas (docs/thresholds.md)"""
_MIN_TURNING_SHARE = 0.3
"""of a window in which a motor must turn, for its friction to be told"""
_WORDS = {
    "mean": "a cable slipped, a load hangs on the arm, or a motor's force is off",
    "along": "friction changed (warmed, worn, oiled)",
    "rms": "a load hangs on the arm, or a law is no longer what it was",
}


@dataclass(frozen=True)
class Finding:
    """One window of one motor that is beyond a limit."""

    time: float
    """s, of the log, where the window begins"""
    motor: int
    """from 1"""
    kind: str
    """mean, along or rms"""
    force: float
    """N"""
    expected: float
    """N: sigma of calibration"""
    ratio: float
    """of the force in units of its limit"""

    def as_json(self) -> dict[str, Any]:
        """For the record."""
        return {
            "time_s": self.time,
            "where": f"motor {self.motor}",
            "kind": self.kind,
            "force_N": self.force,
            "expected_N": self.expected,
            "may_be": _WORDS[self.kind],
        }


@dataclass
class HealthMonitor:
    """Takes rows one by one; sigma: of each motor's unsaid force when it was calibrated, (M,), N."""

    sigma: Array
    findings: list[Finding] = field(default_factory=list)
    loads: list[FoundLoad] = field(default_factory=list)
    """by load_test.py, of the whole log"""
    windows: int = 0
    _began: float | None = None
    _rows: list[tuple[Array, Array]] = field(default_factory=list)

    def add(self, time: float, error: Array, theta_d: Array) -> None:
        """error: the observer's friction error, (M,), N; theta_d: motor speeds, (M,), rad/s."""
        if self._began is None:
            self._began = time + SETTLING_S
        if time < self._began:
            return
        self._rows.append((error, dry(theta_d)))
        if time - self._began >= WINDOW_S:
            self._judge()
            self._began, self._rows = time, []

    def restart(self) -> None:
        """After a gap of the log."""
        self._began, self._rows = None, []

    @property
    def healthy(self) -> bool | None:
        """None where no window was whole."""
        return None if not self.windows else not (self.findings or self.loads)

    def _judge(self) -> None:
        errors, turning = (np.array(v) for v in zip(*self._rows, strict=True))
        self.windows += 1
        mean, rms = errors.mean(axis=0), np.sqrt(np.mean(errors**2, axis=0))
        power = np.sum(turning**2, axis=0)
        along = np.sum((errors - mean) * turning, axis=0) / np.maximum(power, 1e-9)
        along[power < _MIN_TURNING_SHARE * len(errors)] = 0.0
        for j in range(len(mean)):
            ratios = {
                "mean": abs(mean[j]) / (MAX_MEAN_RATIO * self.sigma[j]),
                "along": abs(along[j]) / (MAX_ALONG_RATIO * self.sigma[j]),
                "rms": rms[j] / (MAX_RMS_RATIO * self.sigma[j]),
            }
            kind = max(ratios, key=lambda name: ratios[name])
            if ratios[kind] > 1:
                force = {"mean": mean[j], "along": along[j], "rms": rms[j]}[kind]
                assert self._began is not None
                found = Finding(self._began, j + 1, kind, float(force), float(self.sigma[j]), float(ratios[kind]))
                self.findings.append(found)


def verdict(monitor: HealthMonitor) -> str:
    """`as identified`, `changed`, or `cannot tell`."""
    return {True: "as identified", False: "changed", None: "cannot tell"}[monitor.healthy]


def sentences(monitor: HealthMonitor) -> list[str]:
    """For a person: of each motor and kind the first window, and the worst."""
    if monitor.healthy is None:
        return [f"the log is shorter than {SETTLING_S + WINDOW_S:g} s, so that nothing is said of the arm's health"]
    lines = []
    first: dict[int, list[Finding]] = {}
    for found in monitor.findings:
        first.setdefault(found.motor, []).append(found)
    for motor, own in sorted(first.items()):
        worst = max(own, key=lambda f: f.ratio)
        what = {"mean": "are missing all the time", "along": "act along its motion", "rms": "rms are unexplained"}
        lines.append(
            f"motor {motor} from {own[0].time:.1f} s on is not as identified: {worst.force:.1f} N {what[worst.kind]}, "
            f"where {worst.expected:.1f} N rms were left; {_WORDS[worst.kind]}"
        )
    if monitor.loads:
        load = max(monitor.loads, key=lambda found: abs(found.mass))
        what = "heavier" if load.mass > 0 else "lighter"
        lines.append(
            f"from {monitor.loads[0].time:.1f} s on the tip is {abs(load.mass):.3f} +- {load.sigma:.3f} kg {what} than when "
            "the arm was identified"
        )
    return lines


def as_json(monitor: HealthMonitor) -> dict[str, Any]:
    """The record."""
    return {
        "verdict": verdict(monitor),
        "windows": monitor.windows,
        "findings": [found.as_json() for found in monitor.findings],
        "loads": [{"time_s": load.time, "mass_kg": load.mass, "sigma_kg": load.sigma} for load in monitor.loads],
        "words": sentences(monitor),
    }
