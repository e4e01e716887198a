"""Joints told by motors alone where something is wrong with the arm: by the model that `diagnose` extended, and by the base model.

Each effect of the catalogue is hidden once, on arms off their drawing that are recorded three times for a minute. The first
recording is diagnosed with the second held out, and identified without a diagnosis; of the third the
observer is given the log.
"""

from collections.abc import Iterable
from dataclasses import replace

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


def measure(names: Iterable[str] = tuple(CATALOGUE)) -> Table:
    """Shares of arms within limits by either model, errors, NEES, and what health says."""
    names = list(names)
    seeds = range(FIRST, FIRST + len(names))
    hidden = []
    for name, seed in zip(names, seeds, strict=True):
        drawing = drawn(THRICE, seed)
        hidden.append([CATALOGUE[name](drawing, drawing_rng(drawing))])
    extended: list[Judged] = []
    base: list[Judged] = []
    refused: dict[str, list[str]] = {"extended": [], "base": []}
    lines, said = [], 0
    for name, arm in zip(names, make_arms(list(seeds), THRICE, hidden), strict=True):
        words = []
        neck = description(arm)
        first, second = (data_set(neck, recording) for recording in arm.recordings[:2])
        for kind, runs in (("extended", extended), ("base", base)):
            try:
                told = _diagnosed(first, second) if kind == "extended" else (neck, identified(first))
                judged, health = _observed(arm, *told)
            except Refused as reason:
                refused[kind].append(f"{name} ({reason})")
                words.append(f"{kind} refused")
                said += kind == "base"
                continue
            runs.append(judged)
            words.append(f"{kind} {judged.angle.max():.3f} deg, NEES {judged.nees:.2g}, {health}")
            said += kind == "base" and (
                judged.angle.max() <= LIMIT_DEG or judged.nees <= MAX_TRUE_NEES or health != "as identified"
            )
        lines.append(f"{name}: {'; '.join(words)}.")
    return _table(extended, base, refused, said, lines)


def _observed(arm: Arm, neck: Neck, model: Model) -> tuple[Judged, str]:
    """The third recording by a model, and the word of health."""
    recording = arm.recordings[2]
    seen = observe_log(neck, model, log_of(recording))
    return judge(seen.series, truth_of(recording)), verdict(seen.health)


def _diagnosed(first: DataSet, second: DataSet) -> tuple[Neck, Model]:
    """As `xneck diagnose` writes them."""
    stage = diagnose([first], [second]).extended_stage
    neck = extended_description(stage, [first])
    return neck, calibrated_model(extended_model(stage, {}), [first], neck).model


def _table(
    extended: list[Judged], base: list[Judged], refused: dict[str, list[str]], said: int, lines: list[str]
) -> Table:
    rows = tuple(
        (f"{kind} model", judged_row(runs, len(refused[kind])))
        for kind, runs in (("extended", extended), ("base", base))
        if runs
    )
    count = len(lines)
    within = [sum(run.angle.max() <= WITHIN * limit for run in extended) for limit in (LIMIT_DEG, LIMIT_95_DEG)]
    notes = (
        f"By the extended model {within[0]} of {count} within {WITHIN * LIMIT_DEG:.2f} deg, {within[1]} within "
        f"{WITHIN * LIMIT_95_DEG:.3f}.",
        f"By the base model {said} of {count} are within {LIMIT_DEG} deg, or refused, or sigma or health says that they are not.",
        *lines,
    )
    figures = dict(rows)
    claims = (
        Claim(
            "worst joint's rms with an effect, median of arms, deg",
            f"{count} arms off their drawing, held out",
            figures["extended model"][0] if extended else None,
            ("the base model", figures["base model"][0] if base else None),
        ),
    )
    return Table(f"Joints by motors alone, an effect hidden in each of {count} arms", COLUMNS, rows, claims, notes)
