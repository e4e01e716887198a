"""Whether the arm is still the one identified: the forces that its motors' laws do not model, now and when it was calibrated.

The observer's friction error is the force by which a motor's equation (43) misses its command. Over a window it is held against
the sigma that calibration left: its mean (a pre-elongation that moved, a load), its part along the motor's direction (friction
that changed), and its rms (anything). Windows follow each other, and the last one ends with the log; the first that is beyond a
limit says from when on.

Where forces are missing that exceed all of the motors' friction it is not the arm that changed: the log is of another one, or its
columns mean something else.
"""

from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from mechanism.friction import CM, dry
from observation.load_test import FoundLoad
from observation.turning_rows import MIN_FAST_SHARE, TURNING_SHARE, turning_rows
from xneck_foundation.one_line import counted

Array = NDArray[np.float64]

WINDOW_S = 8.0
"""s: some turns of every motor in lively motion (docs/thresholds.md)"""
SETTLING_S = 2.0
"""s after a begin that are not judged: the observer finds its state first (docs/thresholds.md)"""
MAX_MEAN_RATIO = 0.6
"""mean of a motor's unmodelled force over a window, in sigmas of calibration (docs/thresholds.md)"""
MAX_ALONG_RATIO = 0.9
"""its part along the motor's direction, in those sigmas (docs/thresholds.md)"""
MAX_RMS_RATIO = 1.5
"""its rms, in those sigmas (docs/thresholds.md)"""
Kind = Literal["mean", "along", "rms"]
"""of a deviation: the mean force, its part along the motor's direction, or its rms"""
_LIMITS: dict[Kind, float] = {"mean": MAX_MEAN_RATIO, "along": MAX_ALONG_RATIO, "rms": MAX_RMS_RATIO}
_DEVIATIONS: dict[Kind, str] = {
    "mean": "are missing all the time",
    "along": "act along its motion",
    "rms": "rms are unexplained",
}
_CAUSES: dict[Kind, str] = {
    "mean": "a cable slipped, a load hangs on the arm, or a motor's force is off",
    "along": "friction changed (warmed, worn, oiled)",
    "rms": "a load hangs on the arm, or a law is no longer what it was",
}


_FOREIGN = (
    "is a motor's sign turned, are motors exchanged or counted from another zero, is f in N on the cable, is it another arm's log "
    "or model? Angles are not to be used until that is known"
)
MIN_MOTORS_OFF, MIN_OFF_SIGMAS = 2, 3.0
"""motors whose mean force is off from the beginning on, by more sigmas of calibration, from which on the log is doubted: a model
that lacks something leaves sigmas that are wide (docs/thresholds.md)"""


@dataclass(frozen=True)
class Finding:
    """One window of one motor that is beyond a limit."""

    time: float
    """s, of the log, where the window begins"""
    motor: int
    """from 1"""
    kind: Kind
    force: float
    """N"""
    expected: float
    """N: sigma of calibration"""
    ratio: float
    """of the force in units of its limit"""

    def as_json(self, doubted: str | None) -> dict[str, Any]:
        """For the record; doubted: why the log may be none of this arm's."""
        return {
            "time_s": self.time,
            "where": f"motor {self.motor}",
            "kind": self.kind,
            "force_N": self.force,
            "expected_N": self.expected,
            "may_be": doubted or _CAUSES[self.kind],
        }


@dataclass
class HealthMonitor:
    """Takes rows one by one, and judges each window of them when it is whole."""

    sigma: Array
    """of each motor's unmodelled force when it was calibrated, (M,), N"""
    friction: Array
    """all of each motor's dry friction, (M,), N"""
    findings: list[Finding] = field(default_factory=list)
    loads: list[FoundLoad] = field(default_factory=list)
    """by load_test.py, of the whole log"""
    windows: int = 0
    """that were judged"""
    whole: int = 0
    """windows that were long enough, judged or not"""
    gaps: int = 0
    """of the log, after which a window began anew"""
    first_judged: float | None = None
    """s, of the log, where the first window that was judged begins"""
    judged_to: float | None = None
    """s, of the log, up to which it was judged"""
    _began: float | None = field(default=None, init=False)
    """s, up to which windows were whole, or where rows are settled"""
    _rows: list[tuple[float, Array, Array]] = field(default_factory=list, init=False)
    """of the last window and of the one so far: times, unmodelled forces, and the share of its dry friction that each motor has"""

    def add(self, time: float, error: Array, theta_d: Array) -> None:
        """error: the observer's friction error, (M,), N; theta_d: motor speeds, (M,), rad/s."""
        if self._began is None:
            self._began = time + SETTLING_S
        if time < self._began:
            return
        self._rows.append((time, error, dry(theta_d)))
        if time - self._began >= WINDOW_S:
            self._judge(self._began)

    def end(self) -> None:
        """Where the log ends, or a gap begins: rows since the last whole window are judged with as many before as make one."""
        if not self._rows or self._began is None:
            return
        first, last = self._rows[0][0], self._rows[-1][0]
        if last > self._began and last - first >= WINDOW_S:
            self._judge(self._began)

    def restart(self) -> None:
        """After a gap of the log."""
        self.end()
        self.gaps += 1
        self._began, self._rows = None, []

    @property
    def healthy(self) -> bool | None:
        """None where no window was whole in which a motor turned."""
        return False if self.findings or self.loads else True if self.windows else None

    def _judge(self, began: float) -> None:
        """Judges the last window of the rows; what is found is said to begin at `began`, s: those before were judged already."""
        end = self._rows[-1][0]
        self._rows = [row for row in self._rows if row[0] >= end - WINDOW_S]
        _, *columns = zip(*self._rows, strict=True)
        errors, turning = (np.array(v) for v in columns)
        judged = False
        for j, (error, turn) in enumerate(zip(errors.T, turning.T, strict=True)):
            fast = turning_rows(turn)
            if fast is None:
                continue
            judged = True
            e, direction = error[fast], turn[fast]
            mean, along = np.linalg.lstsq(np.stack([np.ones_like(e), direction], axis=1), e, rcond=None)[0]
            forces: dict[Kind, float] = {
                "mean": float(mean),
                "along": float(along),
                "rms": float(np.sqrt(np.mean(e**2))),
            }
            ratios = {kind: abs(forces[kind]) / (_LIMITS[kind] * float(self.sigma[j])) for kind in get_args(Kind)}
            kind: Kind = max(ratios, key=lambda name: ratios[name])
            if ratios[kind] > 1:
                found = Finding(
                    time=began,
                    motor=j + 1,
                    kind=kind,
                    force=forces[kind],
                    expected=float(self.sigma[j]),
                    ratio=ratios[kind],
                )
                self.findings.append(found)
        if judged and self.first_judged is None:
            self.first_judged = began
        self.windows += judged
        self.whole += 1
        self._began = end
        if judged:
            self.judged_to = end

    @property
    def foreign(self) -> bool:
        """Whether the log is none of this arm's: half of the motors miss more than all of their friction, or it drives one."""
        beyond = self._beyond_friction
        driven = any(f.kind == "along" and f.force < 0 for f in beyond)
        return driven or 2 * len({f.motor for f in beyond}) >= len(self.friction)

    @property
    def off_from_the_beginning(self) -> bool:
        """Whether motors are off in the first window that was judged, and neither friction nor a load alone explains it."""
        first = self._in_first_window
        along = [f for f in first if f.kind == "along"]
        mean = [f for f in first if f.kind == "mean" and abs(f.force) > MIN_OFF_SIGMAS * f.expected]
        every = len(first) == len(self.sigma) > len(along) and bool(along or not self.loads)
        return every or (len(mean) >= MIN_MOTORS_OFF and not self.loads)

    @property
    def doubted(self) -> str | None:
        """Why the log may be none of this arm's, in words; None where it is not doubted."""
        if self.foreign:
            return "the log does not fit this arm"
        return "the log does not fit this arm from its beginning on" if self.off_from_the_beginning else None

    @property
    def doubted_from(self) -> float:
        """s, of the log, from which on its angles are not to be used: minus infinity from its first row, infinity never."""
        if self.doubted is None:
            return np.inf
        begins = min(f.time for f in (self._beyond_friction if self.foreign else self._in_first_window))
        return -np.inf if begins == self.first_judged else begins

    @property
    def _beyond_friction(self) -> list[Finding]:
        return [f for f in self.findings if abs(f.force) > self.friction[f.motor - 1]]

    @property
    def _in_first_window(self) -> list[Finding]:
        return [f for f in self.findings if f.time == self.first_judged]


def verdict(monitor: HealthMonitor) -> str:
    """`as identified`, `changed`, or `cannot tell`."""
    return {True: "as identified", False: "changed", None: "cannot tell"}[monitor.healthy]


def sentences(monitor: HealthMonitor) -> list[str]:
    """For a person: of each motor and kind the first window, and the worst."""
    if monitor.healthy is None:
        return [f"{_why_not_judged(monitor)}: nothing is said of the arm's health"]
    lines = []
    if monitor.foreign:
        lines.append(f"{monitor.doubted}: forces are missing that exceed all of the motors' friction; {_FOREIGN}")
    elif monitor.doubted:
        lines.append(
            f"{monitor.doubted}, and not by friction alone: {_FOREIGN}. Or has a cable slipped, or a load changed, since it was "
            "identified?"
        )
    first: dict[int, list[Finding]] = {}
    for found in monitor.findings:
        first.setdefault(found.motor, []).append(found)
    for motor, own in sorted(first.items()):
        worst = max(own, key=lambda f: f.ratio)
        lines.append(
            f"motor {motor} from {own[0].time:.1f} s on is not as identified: {worst.force:.1f} N {_DEVIATIONS[worst.kind]}, "
            f"where {worst.expected:.1f} N rms were left" + ("" if monitor.doubted else f"; {_CAUSES[worst.kind]}")
        )
    if monitor.loads and not monitor.doubted:
        load = max(monitor.loads, key=lambda found: abs(found.mass))
        what = "heavier" if load.mass > 0 else "lighter"
        lines.append(
            f"from {monitor.loads[0].time:.1f} s on the tip is {abs(load.mass):.3f} +- {load.sigma:.3f} kg {what} than "
            "the model has it"
        )
    return lines


def _why_not_judged(monitor: HealthMonitor) -> str:
    """Why no window was judged."""
    shortest = SETTLING_S + WINDOW_S
    if not monitor.whole:
        between = f"{counted(monitor.gaps, 'gap')} of the log leave no" if monitor.gaps else "the log has no"
        return f"{between} stretch of {shortest:g} s"
    speed = np.tan(np.pi / 2 * TURNING_SHARE) / CM
    return (
        f"in {counted(monitor.whole, 'window')} of {WINDOW_S:g} s no motor turns faster than {speed:.0f} rad/s for "
        f"{100 * MIN_FAST_SHARE:g} % of the time each way"
    )


def as_json(monitor: HealthMonitor) -> dict[str, Any]:
    """The record."""
    return {
        "verdict": verdict(monitor),
        "windows": monitor.windows,
        "judged_to_s": monitor.judged_to,
        "findings": [found.as_json(monitor.doubted) for found in monitor.findings],
        "loads": [{"time_s": load.time, "mass_kg": load.mass, "sigma_kg": load.sigma} for load in monitor.loads],
        "words": sentences(monitor),
    }
