"""Joints told by motors alone where something is wrong with the arm: by the model that `diagnose` extended, and by the base model.

Each effect of the catalogue is hidden once, on arms off their drawing that are recorded three times for a minute. The first
recording is diagnosed with the second held out, and identified without a diagnosis; of the third the observer is given the log.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from benchmarks.ladder import CATALOGUE, drawing_rng
from benchmarks.observer import (
    COLUMNS,
    FIRST_COUNTED,
    LIMIT_95_DEG,
    LIMIT_DEG,
    SEEDS,
    SETTINGS,
    Judged,
    data_set,
    description,
    identified,
    judge,
    judged_row,
    log_of,
    truth_of,
)
from benchmarks.table import Claim, Table
from diagnosis.diagnose import diagnose
from diagnosis.extended_model import extended_description, extended_model
from identification.dataset.dataset import DataSet
from identification.model_file import Model
from identification.pose_calibration import calibrated_model
from mechanism.description import Neck
from observation.health import verdict
from observation.observed_log import observe_log
from samples.forward_arms.arms import Arm, make_arms
from samples.forward_arms.drawing import drawn
from xneck_foundation.errors import Refused

FIRST = FIRST_COUNTED + len(SEEDS)
THRICE = replace(SETTINGS, recordings=3, columns=3 * len(CATALOGUE))
WITHIN = 1.3
"""ratio to the limits of arms with nothing wrong"""
MAX_TRUE_NEES = 2.0
"""per dimension, up to which sigma says how far the angles are off"""


@dataclass(frozen=True)
class Told:
    """What one model made of the third recording of an arm."""

    judged: Judged | None
    """None where the arm was refused"""
    words: str
    says_so: bool
    """whether it is within the limit, or refused, or sigma or health says that it is not"""


def measure(names: Iterable[str] = tuple(CATALOGUE)) -> Table:
    """Shares of arms within limits by either model, errors, NEES, and what health says."""
    names = list(names)
    seeds = range(FIRST, FIRST + len(names))
    drawings = [drawn(THRICE, seed) for seed in seeds]
    hidden = [[CATALOGUE[name](d, drawing_rng(d))] for name, d in zip(names, drawings, strict=True)]
    arms = make_arms(list(seeds), THRICE, hidden)
    return _table(
        {name: [_told(arm, extended) for extended in (True, False)] for name, arm in zip(names, arms, strict=True)}
    )


def _told(arm: Arm, extended: bool) -> Told:
    """By the model that the first recordings give, extended by a diagnosis or not."""
    neck, third = description(arm), arm.recordings[2]
    try:
        first = data_set(neck, arm.recordings[0])
        neck, model = _diagnosed(first, data_set(neck, arm.recordings[1])) if extended else (neck, identified(first))
        seen = observe_log(neck, model, log_of(third))
    except Refused as refused:
        return Told(None, f"refused ({refused})", says_so=True)
    judged, health = judge(seen.series, truth_of(third)), verdict(seen.health)
    worst = float(judged.angle.max())
    says_so = worst <= LIMIT_DEG or judged.nees <= MAX_TRUE_NEES or health != "as identified"
    return Told(judged, f"{worst:.3f} deg, NEES {judged.nees:.2g}, {health}", says_so)


def _diagnosed(first: DataSet, second: DataSet) -> tuple[Neck, Model]:
    """As `xneck diagnose` writes them."""
    stage = diagnose([first], [second]).extended_stage
    neck = extended_description(stage, [first])
    return neck, calibrated_model(extended_model(stage, {}), [first], neck).model


def _table(told: Mapping[str, Sequence[Told]]) -> Table:
    """told: by effect, by the extended model and by the base model."""
    count = len(told)
    kinds = dict(zip(("extended", "base"), zip(*told.values(), strict=True), strict=True))
    runs = {kind: [one.judged for one in each if one.judged] for kind, each in kinds.items()}
    rows = {f"{kind} model": judged_row(each, count - len(each)) for kind, each in runs.items() if each}
    within = [sum(run.angle.max() <= WITHIN * limit for run in runs["extended"]) for limit in (LIMIT_DEG, LIMIT_95_DEG)]
    notes = (
        f"By the extended model {within[0]} of {count} within {WITHIN * LIMIT_DEG:.2f} deg, {within[1]} within "
        f"{WITHIN * LIMIT_95_DEG:.3f}.",
        f"By the base model {sum(one.says_so for one in kinds['base'])} of {count} are within {LIMIT_DEG} deg, or refused, or "
        "sigma or health says that they are not.",
        *(f"{name}: extended {one.words}; base {other.words}." for name, (one, other) in told.items()),
    )
    medians = {kind: rows[f"{kind} model"][0] if each else None for kind, each in runs.items()}
    claims = (
        Claim(
            "worst joint's rms with an effect, median of arms, deg",
            f"{count} arms off their drawing, held out",
            medians["extended"],
            ("the base model", medians["base"]),
        ),
    )
    title = f"Joints by motors alone, an effect hidden in each of {count} arms"
    return Table(title, COLUMNS, tuple(rows.items()), claims, notes)
