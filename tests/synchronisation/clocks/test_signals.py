"""Signals of a log against a motor whose tension is known, integrated in steps of a tenth of the controller's."""

import numpy as np

from identification.dataset.series import Series, numbered_columns
from samples.worlds.clock_worlds import arm
from synchronisation.clocks.signals import log_signals_of

ROW_S, PARTS, DURATION_S = 2e-3, 10, 8.0
FS = 15.0
"""N"""


def tension(time: np.ndarray | float) -> np.ndarray:
    """(..., 4), N, at times (...), s."""
    hertz, phase = np.array([0.7, 1.1, 0.5, 1.3]), np.arange(4.0)
    return 60 + 25 * np.sin(2 * np.pi * hertz * np.asarray(time)[..., None] + phase)


def motor_log() -> Series:
    """Motors that turn to and fro with a command held over each row, friction turning over within less than a row."""
    described = arm()
    inertia = described.motor_inertia / described.drum
    rows = round(DURATION_S / ROW_S)
    time, h = np.linspace(0, ROW_S * (rows - 1), rows), ROW_S / PARTS
    wish = 60 * np.cos(2 * np.pi * 0.6 * time[:, None] + np.arange(4))
    theta, speed = np.zeros(4), wish[0].copy()
    thetas, commands = np.empty((rows, 4)), np.empty((rows, 4))
    rng = np.random.default_rng(3)
    for n in range(rows):
        # a loop as quick as those of real motors, and a command that jumps by half a newton from row to row
        f = tension(time[n]) + FS * np.tanh(speed) + 20 * inertia * (wish[n] - speed) + 0.5 * rng.standard_normal(4)
        thetas[n], commands[n] = theta, f

        def rate(at: float, v: np.ndarray, f: np.ndarray = f) -> np.ndarray:
            return (f - FS * 2 / np.pi * np.arctan(0.5 * v) - tension(at)) / inertia

        for k in range(PARTS):
            at = time[n] + k * h
            a = rate(at, speed)
            b = rate(at + h / 2, speed + h / 2 * a)
            c = rate(at + h / 2, speed + h / 2 * b)
            d = rate(at + h, speed + h * c)
            theta = theta + h * speed + h * h / 6 * (a + b + c)
            speed = speed + h / 6 * (a + 2 * b + 2 * c + d)
    return Series(time, numbered_columns("theta", thetas) | numbered_columns("f", commands))


def test_force_less_friction_is_the_tension_without_delay() -> None:
    """Values at the rows, with a speed below 40 Hz, leave 0.04 N, as forces would that come 0.14 to 0.22 ms sooner than they do."""
    log = motor_log()
    signals = log_signals_of(arm(), log)
    time = log.time[500:-500]
    unexplained = signals.force(time) - FS * signals.dry_friction(time) - tension(time)
    rate = signals.command(time, 1)
    delay = np.sum(unexplained * rate, axis=0) / np.sum(rate**2, axis=0)
    assert np.max(np.std(unexplained, axis=0)) < 0.015
    assert np.max(np.abs(delay)) < 0.07e-3
