"""Clocks of generated recordings with known truth, once as they are and once with each threshold changed."""

import hashlib
import importlib
import pickle
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.threshold import Threshold, scaled
from identification.dataset.series import Series, numbered_columns
from mechanism.cable_lengths import lengths
from samples.worlds.clock_worlds import (
    KINDS,
    NOISE_RAD,
    ClockRecording,
    arm,
    clock_recording,
    switched_light,
    with_lost_frames,
)
from synchronisation.angles import Angles
from synchronisation.clocks import alternative_arms, lost_frame_alignment
from synchronisation.clocks.clock import fit_clock
from synchronisation.clocks.clock_estimate import ClockEstimate
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]

FIRST = 7500
SECONDS = 30.0
ALL = ("theta1", "theta2", "theta3", "theta4")


@dataclass(frozen=True)
class World:
    """A recording, and what is right of it: a clock (true log times of the frames), or a refusal that says `refusal`."""

    name: str
    angles: Angles
    log: Series
    true: Array | None = None
    """log time of every frame, s, where it has a clock"""
    refusal: str = ""
    """what a right refusal says, a pattern"""
    warning: str = ""
    """what a right clock warns of, a pattern; a recording without one is warned of nothing"""


def worlds(folder: Path) -> list[World]:
    """Made once, kept in the folder."""
    file = folder / "worlds.pickle"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        file.write_bytes(pickle.dumps(_made()))
    return pickle.loads(file.read_bytes())


def _made() -> list[World]:
    made = [clock_recording(KINDS[k % 3], FIRST + k, SECONDS) for k in range(6)]
    out = [
        World(f"{FIRST + k} {KINDS[k % 3]}", r.angles, r.log, r.clocks.log_time(r.angles.time))
        for k, r in enumerate(made)
    ]
    for k in (0, 2):
        angles, true, _ = with_lost_frames(made[k], 0.01, FIRST + k)
        out.append(World(f"{FIRST + k} 1 % of frames lost", angles, made[k].log, made[k].clocks.log_time(true)))
    for k in (1, 5):
        out.append(_with_light(made[k], FIRST + k))
    r = made[1]
    time = r.clocks.log_time(r.angles.time)
    out.append(
        World(f"{FIRST + 1} a rope slips by 3 mm", r.angles, _slipped(r.log, 3e-3), time, warning="moved on its drum")
    )
    out.append(World("1 Hz alone", *_periodic(0.0), refusal="repeats itself"))
    angles, log = _periodic(0.05)
    out.append(World("1 Hz and small tones", angles, log, angles.time, warning="nearly repeats"))
    a, log = made[2].angles, made[2].log
    out += [
        World("theta2 turned", a, _turned(log, "theta2"), refusal="theta2 runs against"),
        World(
            "theta1 and theta3 exchanged",
            a,
            _exchanged(log, "theta1", "theta3"),
            refusal="theta1 and theta3 are swapped",
        ),
        World("theta4 and f4 exchanged", a, _exchanged(log, "theta4", "f4"), refusal="cable 4 contradicts"),
        World("angles in another order", replace(a, alpha=a.alpha[:, [1, 0, 2]]), log, refusal="order 2, 1, 3"),
        World("a mirrored arm", replace(a, alpha=-a.alpha), _turned(log, *ALL), refusal="all signs turned"),
        World(
            "joints and cables renumbered",
            replace(a, alpha=a.alpha[:, [1, 0, 2]]),
            _exchanged(_exchanged(log, "theta1", "theta2"), "f1", "f2"),
            refusal="angles in the order 2, 1, 3",
        ),
        World("the log of another recording", a, made[5].log, refusal="same motion|overlap"),
        World("an arm at rest", replace(a, alpha=0 * a.alpha + 0.1), log, refusal="move by"),
        World("3 s of log", a, _until(log, log.time[0] + 4.0), refusal="overlap|shorter"),
    ]
    return out


def _with_light(r: ClockRecording, seed: int) -> World:
    shone = switched_light(r.clocks, r.angles.time, seed, changes=40, rows=r.log.time)
    log = Series(r.log.time, {**r.log.columns, "led": shone.led})
    notes = {"light": {"exposure_s": 0.004, "later_s": 0.0}}
    angles = replace(r.angles, light=shone.brightness, notes=notes)
    return World(f"{seed} with a light", angles, log, r.clocks.log_time(r.angles.time))


def _slipped(log: Series, size: float) -> Series:
    theta = log.matrix("theta").copy()
    theta[:, 1] += np.where(log.time > log.time.mean(), size / arm().drum[1], 0.0)
    return Series(log.time, {**log.columns, **numbered_columns("theta", theta)})


def _turned(log: Series, *names: str) -> Series:
    return Series(log.time, {**log.columns, **{name: -log.columns[name] for name in names}})


def _exchanged(log: Series, a: str, b: str) -> Series:
    columns = dict(log.columns)
    columns[a], columns[b] = columns[b], columns[a]
    return Series(log.time, columns)


def _until(log: Series, end: float) -> Series:
    kept = log.time < end
    return Series(log.time[kept], {name: column[kept] for name, column in log.columns.items()})


def _periodic(beside: float) -> tuple[Angles, Series]:
    """A sinusoid of 1 Hz on rigid cables, and nine tones of `beside` rad each; both clocks are one."""
    hertz, phase = np.geomspace(0.3, 2.5, 9), np.random.default_rng(FIRST).uniform(0, 6, (9, 3))
    t, T = np.arange(600, dtype=float) / 30, 0.002 * np.arange(12_000, dtype=float) - 2

    def alpha(t: Array) -> Array:
        tones = [[np.sin(2 * np.pi * f * t + q) for f, q in zip(hertz, own, strict=True)] for own in phase.T]
        return np.column_stack(
            [0.2 * np.sin(2 * np.pi * t + p) + beside * np.sum(tones[i], axis=0) for i, p in enumerate((0.0, 1.0, 2.0))]
        )

    theta = -(lengths(arm(), alpha(T)) - lengths(arm(), np.zeros(3))) / arm().drum
    log = Series(T, numbered_columns("theta", theta) | numbered_columns("f", np.full(theta.shape, 40.0)))
    return Angles(t, alpha(t), np.full((len(t), 3), NOISE_RAD)), log


def judged(world: World) -> Outcome:
    """The clock as it is now against the truth."""
    try:
        clock = fit_clock(arm(), world.angles, world.log)
    except Refused as refusal:
        said = str(refusal)
        right = bool(world.refusal and re.search(world.refusal, said))
        # a refusal that names something wrong is false; one of a good recording too
        return Outcome(right, not right and not world.refusal, said[:160])
    if world.true is None:
        return Outcome(False, True, f"accepted, offset {clock.offset:.4f} s")
    return _of_clock(clock, world)


def _of_clock(clock: ClockEstimate, world: World) -> Outcome:
    assert world.true is not None
    error = float(np.median(clock.log_time(world.angles.time) - world.true))
    z = error / clock.offset_sigma
    warned = "; ".join(clock.warnings)
    as_wanted = bool(re.search(world.warning, warned)) if world.warning else not warned
    near = abs(z) < 3
    said = f"{1e3 * error:+.3f} ms, z {z:+.1f}, {clock.source}" + (f"; {warned[:100]}" if warned else "")
    return Outcome(near and as_wanted, not near or (bool(warned) and not world.warning), said)


@contextmanager
def fits_kept() -> Iterator[None]:
    """Fits of the same frames and signals with the same constants are made once."""
    with ExitStack() as stack:
        places = (
            (lost_frame_alignment, "align_finely"),
            (lost_frame_alignment, "fit_cables"),
            (alternative_arms, "fit_cables"),
        )
        for module, name in places:
            stack.enter_context(patch.object(module, name, _memo(getattr(module, name))))
        yield


def _memo(function: Callable[..., Any]) -> Callable[..., Any]:
    known: dict[bytes, tuple[Any, Refused | None]] = {}

    def asked(*args: Any) -> Any:
        key = hashlib.blake2b(pickle.dumps((args, _constants()))).digest()
        if key not in known:
            try:
                known[key] = (function(*args), None)
            except Refused as refusal:
                known[key] = (None, refusal)
        result, refusal = known[key]
        if refusal is not None:
            raise refusal
        return result

    return asked


def _constants() -> Sequence[Any]:
    """Values of the constants that fits read, as they are now."""
    names = (
        "fine_alignment", "gauss_newton_fit", "gauss_newton_step", "cable_equation", "arm_equation", "arm_nuisances",
        "frame_geometry", "unknowns",
    )  # fmt: skip
    held = (vars(importlib.import_module(f"synchronisation.clocks.{name}")) for name in names)
    return tuple((k, repr(v)) for each in held for k, v in each.items() if k.isupper())


def _thresholds() -> list[Threshold]:
    def of(module: str, *names: str) -> list[Threshold]:
        return scaled(f"synchronisation.clocks.{module}", *names)

    coarse, labels = "synchronisation.clocks.coarse_alignment", "synchronisation.clocks.exchanged_labels"
    return [
        Threshold(coarse, "MAX_SECOND_PEAK", 0.95, 0.8),
        Threshold(coarse, "SECOND_PEAK_WARNING", 0.925, 0.7),
        *of("coarse_alignment", "MIN_OVERLAP_S", "MIN_PEAK_SEPARATION_S", "WINDOW_S"),
        Threshold(labels, "MIN_CORRELATION", 0.9, 0.6),
        Threshold(labels, "MIN_CABLE_CORRELATION", 0.8, 0.2),
        Threshold(labels, "EXCHANGE_CORRELATION", 0.95, 0.8),
        *of("exchanged_labels", "MIN_LEAD"),
        *of("alternative_arms", "SUSPICIOUS_M", "HEALTHY_M", "MAX_ERROR_RATIO", "PULLEY_SIGMA"),
        *of("usable_frames", "EDGE_S", "GAP_MARGIN_S", "MIN_FRAMES"),
        *of("motion_clock", "MIN_TRAVEL_M"),
        *of("clock", "DISAGREEMENT_SIGMA"),
        *of("lost_frame_alignment", "MAX_SKEW", "MAX_RESIDUAL_M", "WINDOW_S", "MAX_WINDOWS", "MAX_WINDOW_SHIFT_S"),
        *of("lost_frame_alignment", "WINDOW_CABLE_ERROR_M", "DECODING_CABLE_ERROR_M"),
        *of("lost_frames", "LOSS_COST", "NEXT_LOSS_COST", "MAX_FRAME_COST"),
        *of("winch_slips", "MIN_SLIP_M", "MIN_SLIP_RATIO", "MAX_SLIPS"),
        Threshold("synchronisation.clocks.winch_slips", "MIN_VARIANCE_RATIO", 1.125, 1.5),
        Threshold("synchronisation.clocks.fine_alignment", "MAX_MISFIT_RATIO", 1.075, 1.3),
        *of("fine_alignment", "OFFSET_BIAS_SIGMA_S"),
        *of("gauss_newton_fit", "OUTLIER_SIGMA", "MAX_OFFSET_CHANGE_S"),
        *of("gauss_newton_step", "SKEW_SIGMA", "BLOCK_S", "FV_SIGMA"),
        *scaled("identification.unknowns", "DELAY_SIGMA_S"),
        *scaled("mechanism.drawing_errors", "MAX_DRAWING_ERROR"),
        *of("arm_nuisances", "PAYLOAD_SIGMA", "TILT_SIGMA_RAD", "GAIN_SIGMA", "LOSS_SIGMA"),
        *of("arm_equation", "SLOW_JOINT_RAD_S"),
        *of("frame_geometry", "MIN_CABLE_ERROR_M", "MIN_NOISE_SCALE"),
        *of("light", "MIN_SWITCHES", "MIN_CONTRAST", "SEARCH_RANGE_S", "MAX_SEARCHED_SKEW", "MIN_BRIGHTNESS_NOISE"),
        *of("light", "MAX_DEVIATION_SIGMA", "MAX_MISFIT"),
        Threshold("synchronisation.clocks.light", "MIN_LIGHT_CORRELATION", 0.85, 0.4),
        *scaled("identification.dataset.true_rows", "MIN_REPEATED_ROWS", "MIN_JUMP_COUNTS"),
        *of("log_gaps", "MIN_GAP_S"),
    ]


ROOM = Room("clocks", worlds, judged, _thresholds, fits_kept)
