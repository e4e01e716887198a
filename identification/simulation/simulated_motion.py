"""A motion that was designed and not yet played, through a model: what the arm would do under its forces."""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any, get_args

import numpy as np

from identification.dataset.series import Series, check_time, from_one, numbered_columns
from identification.dataset.time_unit import check_time_unit
from identification.design.nominal_machine import nominal_machine
from identification.files.mcap_losses import rows_after_gaps
from identification.model_file import Model, machine_of
from identification.simulation.simulated_recording import Source
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.geometry import check_angles
from mechanism.simulation import State, simulate, simulate_given_angles
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.one_blas_thread import one_blas_thread


@dataclass(frozen=True)
class SimulatedMotion:
    """The simulated motion beside the designed one, on the same times."""

    series: Series
    """columns alphaI, thetaJ, tensionJ and fJ as simulated, and alphaI_designed, thetaJ_designed, fJ_designed"""
    source: Source
    assumed: bool = False
    """whether the model was not identified, but like that of Fasquelle's arm"""

    @property
    def rms(self) -> dict[str, float]:
        """Simulated less designed, by channel: alphaI, rad, and thetaJ, rad, from forces, or fJ, N, from motor angles."""
        stems = ("alpha", "theta") if self.source == "f" else ("alpha", "f")
        errors = {
            f"{stem}{i + 1}": column
            for stem in stems
            for i, column in enumerate((self.series.matrix(stem) - self.series.matrix(stem, "_designed")).T)
        }
        return {name: float(np.sqrt(np.mean(error**2))) for name, error in errors.items()}

    def as_json(self) -> dict[str, Any]:
        """What `simulate --json` says of a motion."""
        tension = self.series.matrix("tension")
        return {
            "from": self.source,
            "model": "assumed" if self.assumed else "given",
            "seconds": float(self.series.time[-1] - self.series.time[0]),
            "rms": self.rms,
            "reached": {
                "alpha_rad": np.abs(self.series.matrix("alpha")).max(axis=0).tolist(),
                "tension_min_N": float(tension.min()),
                "tension_max_N": float(tension.max()),
            },
        }

    def as_text(self) -> str:
        """Errors and reach for a person."""
        record = self.as_json()
        given = {"f": "the designed forces", "theta": "the designed motor angles"}[self.source]
        shown = ", ".join(
            f"{name} {value:.2g} N" if name.startswith("f") else f"{name} {degrees(value):.2g} deg"
            for name, value in self.rms.items()
        )
        reached = record["reached"]
        by = "\n  motors and cables are taken to be like Fasquelle's; give --model once this arm is identified"
        angles = ", ".join(f"{degrees(a):.1f}" for a in reached["alpha_rad"])
        return (
            f"simulated less designed, from {given} over {record['seconds']:.1f} s, rms: {shown}\n"
            f"  angles up to {angles} deg, tensions {reached['tension_min_N']:.0f} to {reached['tension_max_N']:.0f} N"
            f"{by if self.assumed else ''}"
        )


def motion_columns(neck: Neck) -> list[str]:
    """Columns that a motion of this arm has beside time."""
    stems = (("alpha", neck.N), ("theta", neck.M), ("f", neck.M))
    return [f"{stem}{k + 1}" for stem, count in stems for k in range(count)]


def check_motion(motion: Series, neck: Neck, where: str | Path, number: Callable[[int], int] = from_one) -> None:
    """Raises Refused where a motion of this arm lacks a column, a number or rows, or its time is in no seconds.

    number: what a person calls a row, which is counted from 0."""
    check_time_unit(motion.time, str(where), "samples")
    check_time(motion.time, str(where), number)
    if gaps := rows_after_gaps(motion.time):
        seconds = motion.time[gaps[0]] - motion.time[gaps[0] - 1]
        what = f"rows are missing before row {number(gaps[0])}, which is {seconds:.3g} s after the one before"
        raise Refused(where, what, "give rows of even steps")
    for name in motion_columns(neck):
        if name not in motion.columns:
            raise Refused(where, f"lacks the column {name}", "is it a motion of this arm, by `xneck design`?")
        if not np.all(np.isfinite(motion.columns[name])):
            row = number(int(np.argmin(np.isfinite(motion.columns[name]))))
            raise Refused(where, f"{name} is not a number in row {row}", "give a number in every row")


@one_blas_thread
def simulate_motion(
    motion: Series, neck: Neck, model: Model | None = None, source: Source = "f", where: str | Path = "motion"
) -> SimulatedMotion:
    """The arm with the model's laws from the motion's first row on, at rest there, under its forces or with its motor angles.

    motion: columns alphaI, rad, thetaJ, rad, and fJ, N, as `xneck design` writes them. It runs freely: nothing brings it back to
    the designed motion, so that what it does under the forces alone may drift from that. model: None for one with motors and cables
    like those of Fasquelle's arm, as `xneck design` assumes. Raises Refused as `check_motion` does, and where the arm leaves the
    range of its mechanisms.

    >>> import xneck
    >>> neck, model = xneck.read_neck("samples/recording/neck.yaml"), xneck.read_model("model.yaml")
    >>> simulated = xneck.simulate_motion(xneck.read_motion("motion.csv", neck), neck, model, source="theta")
    >>> simulated.rms["alpha1"] < 0.01  # rad
    True
    """
    one_of("simulate", source, get_args(Source), "source")
    check_motion(motion, neck, where)
    alpha, theta, f = (motion.matrix(stem) for stem in ("alpha", "theta", "f"))
    check_angles(arm_of(neck), alpha, str(where))
    machine = machine_of(model, arm_of(neck)) if model else nominal_machine(neck)
    rest = State(alpha[0], np.zeros(neck.N), theta[0], np.zeros(neck.M))
    if source == "f":
        simulated = simulate(machine, rest, motion.time, f)
    else:
        theta_d = np.gradient(theta, motion.time, axis=0)
        angles = (theta, theta_d, np.gradient(theta_d, motion.time, axis=0))
        simulated = simulate_given_angles(machine, rest, motion.time, angles)
    columns = numbered_columns("alpha", simulated.alpha) | numbered_columns("theta", simulated.theta)
    columns |= numbered_columns("tension", simulated.tension) | numbered_columns("f", simulated.f)
    for stem, designed in (("alpha", alpha), ("theta", theta), ("f", f)):
        columns |= numbered_columns(stem, designed, "_designed")
    return SimulatedMotion(Series(motion.time, columns), source, assumed=model is None)
