"""Runs go on where they were stopped, arm by arm, and what names an effect is counted as such."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.forward_arm_runs import SETTINGS, Runs, Scene, SeenArm, seed_range, share
from benchmarks.hidden_by_noise import SCENES, named_alone, named_in_set
from benchmarks.tuned_seeds import FIRST_COUNTED_FORWARD_ARM
from diagnosis.effects import EFFECTS
from samples.forward_arms.laws import Payload
from xneck_foundation.errors import Refused

TINY = replace(SETTINGS, mechanisms=1, seconds=0.2, recordings=1, offset=(-0.05, 0.05))
BOTH = (Scene("clean"), Scene("tip_payload", lambda drawing: [Payload(drawing.bar_mass[-1])]))


def described(arm: SeenArm) -> dict[str, Any]:
    """What a run is told, and no diagnosis; one arm is refused."""
    (film,), (recording,) = arm.films, arm.arm.recordings
    if arm.arm.seed == 1003 and not arm.arm.laws:
        raise Refused("arm", "is not wanted")
    return {
        "verdict": "cause",
        "causes": [type(law).__name__ for law in arm.arm.laws],
        "noise": float(np.degrees(film.noise)),
        "drawn": ((film.seen - film.mean) / film.noise).tolist(),
        "mean": film.mean.tolist(),
        "motion": float(recording.truth.alpha.sum()),
        "weight": float(arm.arm.plant.bar_mass[-1] / arm.arm.drawing.bar_mass[-1]),
    }


def test_runs_are_made_once_and_all_noises_see_one_motion(tmp_path: Path) -> None:
    runs = Runs(tmp_path, BOTH, (1002, 1003), (0.01, 0.1), TINY)
    stopped = runs.complete(described)
    first, second = next(stopped), next(stopped)
    assert (first["noise"], second["noise"]) == pytest.approx((0.01, 0.1))
    assert first["motion"] == second["motion"]
    assert first["mean"] == second["mean"]
    np.testing.assert_allclose(first["drawn"], second["drawn"], rtol=1e-6)
    others = list(runs.complete(described))
    assert [(r["scene"], r["seed"], r["noise_deg"]) for r in others] == [
        ("tip_payload", 1002, 0.01),
        ("tip_payload", 1002, 0.1),
        ("clean", 1003, 0.01),
        ("clean", 1003, 0.1),
        ("tip_payload", 1003, 0.01),
        ("tip_payload", 1003, 0.1),
    ]
    assert [r.get("weight") for r in others] == pytest.approx([2.0, 2.0, None, None, 2.0, 2.0])
    assert others[2]["refused"] == "arm: is not wanted"
    assert list(runs.complete(described)) == []
    assert runs.done(BOTH[1], 0.1) == [others[1], others[5]]
    assert runs.sources() == f"Runs by digest of the sources: 8 by {first['source']}."


def test_other_settings_are_other_runs(tmp_path: Path) -> None:
    runs = Runs(tmp_path, BOTH, (1002,), (0.1,), TINY)
    other = replace(runs, settings=replace(TINY, seconds=0.3))
    assert runs.file(BOTH[0], 1002, 0.1) != other.file(BOTH[0], 1002, 0.1)


def test_names_are_counted_alone_and_in_sets() -> None:
    alone = {"verdict": "cause", "causes": ["tip_payload"], "sets": [["tip_payload"]]}
    tied = {"verdict": "ambiguous", "causes": ["base_tilt"], "sets": [["base_tilt", "tip_payload"]]}
    two = {"verdict": "cause", "causes": ["tip_payload", "base_tilt"], "sets": [["tip_payload"], ["base_tilt"]]}
    none = {"verdict": "insufficient", "causes": ["tip_payload"], "sets": [["tip_payload"]]}
    records = (alone, tied, two, none, {"refused": "no motion"})
    assert [named_alone(r, "tip_payload") for r in records] == [True, False, False, False, False]
    assert [named_in_set(r, "tip_payload") for r in records] == [True, True, True, False, False]


def test_hidden_effects_have_the_diagnosis_names() -> None:
    assert {scene.name for scene in SCENES} <= set(EFFECTS)


def test_words_of_the_command_line() -> None:
    first = FIRST_COUNTED_FORWARD_ARM
    assert seed_range(f"{first}-{first + 2}") == [first, first + 1, first + 2]
    assert seed_range(f"{first}") == [first]
    assert share("1/2") == (1, 2)
    for function, word in (
        (seed_range, f"{first - 1}-{first}"),
        (seed_range, f"{first + 1}-{first}"),
        (seed_range, "all"),
        (share, "2/2"),
    ):
        with pytest.raises(argparse.ArgumentTypeError):
            function(word)
