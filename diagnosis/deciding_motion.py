"""The motion that would settle a diagnosis: what it left open, asked of motions within limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from diagnosis.diagnose import Diagnosis
from diagnosis.extended_model import extended_description, extended_model
from diagnosis.motion_questions import open_questions
from diagnosis.planned_motion import Answer, Question, motion_judge
from identification.dataset.dataset import DataSet
from identification.design.information import AngleNoise
from identification.design.search import DesignedMotion, SearchOptions, design_motion, design_target
from identification.design.trajectory import MotionLimits
from identification.model_file import machine_of
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.machine import Machine

MIN_SECONDS, MAX_SECONDS = 12.0, 60.0
"""s: a motion is as long as the recordings, within these (docs/thresholds.md)"""
_DRAWS, _CHANGES = 8, 4
"""motions that are compared: as many as take some seconds"""


@dataclass(frozen=True)
class DecidingMotion:
    """A motion, and how it answers the questions that it was made for."""

    designed: DesignedMotion
    answers: tuple[Answer, ...]


def deciding_motion(
    d: Diagnosis, recordings: Sequence[DataSet], limits: MotionLimits, draws: int = _DRAWS, changes: int = _CHANGES
) -> DecidingMotion | None:
    """For a diagnosis of these recordings, as long as the longest of them, on the extended model; None where nothing is open.

    Raises Refused where the arm cannot move within the limits.
    """
    questions = open_questions(d)
    if not questions:
        return None
    seconds = max(float(data.state.time[-1] - data.state.time[0]) for data in recordings)
    options = SearchOptions(float(np.clip(round(seconds), MIN_SECONDS, MAX_SECONDS)), draws=draws, changes=changes)
    neck = extended_description(d.extended_stage, recordings)
    machine = machine_of(extended_model(d.extended_stage, {}), arm_of(neck))
    return motion_for(neck, machine, questions, (), limits, _angle_noise(recordings), options)


def motion_for(
    neck: Neck,
    machine: Machine,
    questions: Sequence[Question],
    parameters: Sequence[str],
    limits: MotionLimits,
    noise: AngleNoise,
    options: SearchOptions,
    progress: Callable[[int], object] = lambda tried: None,
) -> DecidingMotion:
    """The motion that answers questions, and determines parameters of laws by name, best."""
    target = design_target(machine, parameters)
    if not questions:
        return DecidingMotion(design_motion(machine, target, limits, noise, options, progress), ())
    judge = motion_judge(neck, machine, questions, noise)
    designed = design_motion(machine, target, limits, noise, options, progress, judge.shortfall)
    return DecidingMotion(designed, judge.answers(designed.motion))


def answers_json(judged: DecidingMotion) -> list[dict[str, Any]]:
    """For the record."""
    return [
        {
            "effect": a.question.effect.name,
            "beside": a.question.beside and a.question.beside.name,
            "over_needed": a.ratio,
            "tells": a.ratio > 1,
        }
        for a in judged.answers
    ]


def answers_text(judged: DecidingMotion) -> str:
    """A line for each question."""
    lines = []
    for a in judged.answers:
        other = a.question.beside
        words = f"{a.question.effect.name} told from {other.name}" if other else f"{a.question.effect.name} shown"
        lines.append(f"  {words}: {a.ratio:.2g} times what it takes{'' if a.ratio > 1 else ', which is too little'}")
    return "\n".join(lines)


def _angle_noise(recordings: Sequence[DataSet]) -> AngleNoise:
    """Of the frames of recordings, at their medians."""
    frames = [data.angles for data in recordings]
    sigma = np.concatenate([f.matrix("sigma").ravel() for f in frames])
    return AngleNoise(float(np.nanmedian(sigma)), float(np.median([1 / np.median(np.diff(f.time)) for f in frames])))
