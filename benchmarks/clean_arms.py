"""Arms on which nothing is hidden, at five noises: what is said of them, and whether each sigma is as large as its errors.

Arms are drawn at random and integrated forward by a generator that shares no code with what reads them. Both recordings of an arm
are synchronised; from the first one friction and elasticity are identified, and it is diagnosed with the second held out. A hundred
arms take hours: runs are kept, and go on where they were stopped.

`python -m benchmarks.clean_arms --out FOLDER [--seeds 1003-1102] [--noises 0.02 0.1] [--share 0/2]` makes the runs alone.
"""

import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures.rate import rate
from benchmarks.forward_arm_runs import Record, Runs, Scene, SeenArm, main, percent, topic_folder, verdict
from benchmarks.nees import nees_per_dimension
from benchmarks.table import Table
from benchmarks.tuned_seeds import FIRST_COUNTED_FORWARD_ARM
from benchmarks.verdict_record import verdict_record
from diagnosis.diagnose import diagnose
from identification.dataset.dataset import DataSet
from identification.estimates import estimate
from samples.forward_arms.arms import Truth
from samples.forward_arms.camera import Film
from samples.forward_arms.plant import Plant
from xneck_foundation.parameter import Parameter

Array = NDArray[np.float64]

SEEDS = range(FIRST_COUNTED_FORWARD_ARM, FIRST_COUNTED_FORWARD_ARM + 100)
NOISES_DEG = (0.005, 0.01, 0.02, 0.05, 0.1)
CLEAN = Scene("clean")
INTERVAL = 1.96
"""sigmas of a 95 % interval"""
COLUMNS = (
    "consistent %",
    "from %",
    "to %",
    "over floor",
    "over floor, 95th",
    "clock ms",
    "clock z",
    "NEES alpha",
    "NEES alpha'",
    "NEES alpha''",
    "joint",
    "covered %",
    "z",
    "sigma fs N",
    "s sync",
    "s diagnose",
    "arms",
)


def measure(seeds: Sequence[int] = SEEDS, noises: Sequence[float] = NOISES_DEG, folder: Path | None = None) -> Table:
    """Verdicts with their exact 95 % interval, residuals over the noise floor, errors over sigma of clock, state and parameters.

    Residuals are those of the base model where it was fitted, channel by channel. 1 is right for z and for NEES per dimension,
    95 % for what intervals cover. Times are processor seconds: of two recordings, and of one diagnosis.
    """
    runs = runs_in(folder or topic_folder("clean_arms"), seeds, noises)
    for _ in runs.complete(judged):
        pass
    return table(runs)


def runs_in(folder: Path, seeds: Sequence[int], noises: Sequence[float]) -> Runs:
    """Clean arms, kept in a folder."""
    return Runs(folder, (CLEAN,), seeds, noises)


def table(runs: Runs) -> Table:
    """What the runs come to that a folder holds, a row per noise."""
    rows = [(f"{noise:g} deg", _row(records)) for noise in runs.noises if (records := runs.done(CLEAN, noise))]
    seconds = f"{runs.settings.seconds:g} s"
    return Table(f"Clean arms, two recordings of {seconds} each", COLUMNS, tuple(rows), notes=(runs.sources(),))


def judged(arm: SeenArm) -> Record:
    """The record of an arm at one noise, ready for JSON."""
    begin = time.process_time()
    fitted, held_out = (arm.synchronised(i) for i in range(2))
    synchronised = time.process_time()
    estimates = estimate([fitted])
    identified = time.process_time()
    found = diagnose([fitted], [held_out])
    diagnosed = time.process_time()
    read = (fitted, held_out)
    return verdict_record(found) | {
        "clocks": [clock_record(data, film) for data, film in zip(read, arm.films, strict=True)],
        "states": [_state(data, r.truth) for data, r in zip(read, arm.arm.recordings, strict=True)],
        "parameters": list(_parameters(estimates.parameters, arm.arm.plant)),
        "sync_s": synchronised - begin,
        "identify_s": identified - synchronised,
        "diagnose_s": diagnosed - identified,
    }


def clock_record(data: DataSet, film: Film) -> Record:
    """Errors of offset (at the middle of the frames) and skew, with their sigmas."""
    clock = data.clock
    truth = film.offset + film.skew * clock["camera_middle_s"]
    return {
        "error_ms": 1e3 * (clock["offset_s"] - truth),
        "sigma_ms": 1e3 * clock["offset_sigma_s"],
        "skew_error_ppm": clock["skew_ppm"] - 1e6 * film.skew,
        "skew_sigma_ppm": clock["skew_sigma_ppm"],
    }


def _state(data: DataSet, truth: Truth) -> Record:
    """How the state was estimated, and its NEES per dimension where the data set has the covariance."""
    e, covariance = state_errors(data, truth)
    return {"method": data.clock["state"]["method"], "nees": nees_per_dimension(e, covariance).tolist()}


def state_errors(data: DataSet, truth: Truth) -> tuple[Array, Array]:
    """Errors (K, 3 N) of alpha, alpha', alpha'' at the times of the data set's covariance (K, 3 N, 3 N).

    True alpha'' is the mean over the step before and the step after. What the equations make of a state that was integrated in
    steps of a row errs by as much as the estimate does (.03-.18 rad/s^2 against steps of a sixteenth): cables' damping is stiff,
    and a stiff method's states are more precise than their rates.
    """
    assert data.covariance is not None
    at, columns = data.covariance.time, data.covariance.columns
    names = [f"alpha{i + 1}{suffix}" for suffix in ("", "_d", "_dd") for i in range(truth.alpha.shape[1])]
    covariance = np.array([[columns[_covariance_name(names, a, b)] for b in names] for a in names])
    rows, steps = (np.searchsorted(time, at - 1e-6) for time in (data.state.time, truth.time))
    estimated = np.stack([data.state.columns[name][rows] for name in names], axis=-1)
    step = float(truth.time[1] - truth.time[0])
    alpha_dd = (truth.alpha_d[steps + 1] - truth.alpha_d[steps - 1]) / (2 * step)
    true = np.hstack([truth.alpha[steps], truth.alpha_d[steps], alpha_dd])
    return estimated - true, np.moveaxis(covariance, -1, 0)


def _covariance_name(names: list[str], a: str, b: str) -> str:
    """The column of the upper triangle."""
    first, second = sorted((a, b), key=names.index)
    return f"cov_{first}_{second}"


def _parameters(found: Sequence[Parameter], plant: Plant) -> Iterator[Record]:
    """Each cable's friction, stiffness, damping and pre-elongation beside the truth."""
    truth = {"fs": plant.dry, "k": plant.stiffness, "ca": plant.damping, "x0": plant.x0}
    for p in found:
        if p.name in truth and p.index is not None:
            error = p.value - float(truth[p.name][p.index - 1])
            yield {
                "name": p.name,
                "index": p.index,
                "error": error,
                "sigma": p.sigma,
                "z": error / p.sigma,
                "covered": abs(error) <= INTERVAL * p.sigma,
                "identified": p.identified,
            }


def _row(records: Sequence[Record]) -> tuple[float | None, ...]:
    """The figures of one noise; arms that were refused count as not consistent, and nowhere else; nor do infinite sigmas."""
    read = [r for r in records if "refused" not in r]
    consistent = percent(rate(verdict(r) == "consistent" for r in records))
    if not read:
        return (*consistent, *[None] * (len(COLUMNS) - 4), float(len(records)))
    over = [value for r in read for value in (*r["motors_over_floor"], *r["joints_over_floor"])]
    clocks = [clock for r in read for clock in r["clocks"] if clock["sigma_ms"] is not None]
    nees = np.mean([state["nees"] for r in read for state in r["states"]], axis=0)
    parameters = [p for r in read for p in r["parameters"] if p["sigma"] is not None]
    return (
        *consistent,
        float(np.median(over)),
        float(np.percentile(over, 95)),
        _rms([clock["error_ms"] for clock in clocks]),
        _rms([clock["error_ms"] / clock["sigma_ms"] for clock in clocks]),
        *nees.tolist(),
        100 * float(np.mean([p["covered"] for p in parameters])),
        _rms([p["z"] for p in parameters]),
        float(np.median([p["sigma"] for p in parameters if p["name"] == "fs"])),
        float(np.median([r["sync_s"] for r in read])),
        float(np.median([r["diagnose_s"] for r in read])),
        float(len(records)),
    )


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    sys.exit(main("benchmarks.clean_arms", __doc__ or "", runs_in, judged, (SEEDS, NOISES_DEG), sys.argv[1:]))
