"""How to go on with a cause, by what the recordings were read with."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from diagnosis.advice import advice
from mechanism.description import Neck, read_neck
from tests.paths import NECK_FILE

WITH_MARKERS = read_neck(NECK_FILE)
WITHOUT = WITH_MARKERS.model_copy(update={"markers": None})


def one_cause(neck: Neck) -> Any:
    """A diagnosis that names one cause of an arm, beside which nothing explains as much."""
    named = SimpleNamespace(tied=("itself",))
    return SimpleNamespace(
        verdict="cause",
        search=SimpleNamespace(named=(named,)),
        set_aside=((), ()),
        extended_stage=SimpleNamespace(hypothesis=SimpleNamespace(neck=neck)),
    )


@pytest.mark.parametrize(
    ("neck", "commands"),
    [
        (WITH_MARKERS, ["extract", "sync", "simulate"]),
        (WITHOUT, ["sync", "simulate"]),
    ],
)
def test_a_video_is_read_anew_where_the_arm_has_markers(neck: Neck, commands: list[str]) -> None:
    """Where no markers are described no camera read them, and there is no video to extract angles from."""
    steps = advice(cast("Any", one_cause(neck)))
    assert [step.command.split()[1] for step in steps] == commands
    assert all(step.command.startswith("xneck ") for step in steps)
    assert ("video" in steps[0].words) == (neck.markers is not None)
