"""What a record says of clocks and of effects that look alike, by hand."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from diagnosis.cause import Cause, with_causes
from diagnosis.detectability import Detectability
from diagnosis.effects import EFFECTS
from diagnosis.hypothesis import Hypothesis, as_described
from diagnosis.noise_excess import NoiseExcess
from diagnosis.record import as_json
from diagnosis.residual_episodes import RmsCourse
from diagnosis.signature import Signature
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

NECK = read_neck(NECK_FILE)
CHANNELS = 7
VISIBLE = Detectability(
    effects=("tip_payload", "base_tilt", "clock_offset"),
    imitated=np.array([[1.0, 0.95, 0.2], [0.3, 1.0, 0.91], [0.1, 0.4, 1.0]]),
    shown=(True, True, True),
    invisible_places=(),
)


def found(h: Hypothesis, frame_lags: list[float]) -> Any:
    """A diagnosis in which nothing stands above noise; frame_lags: of each recording's own clock, s."""
    noise = NoiseExcess(np.ones(CHANNELS), np.ones(CHANNELS))
    ones = np.ones((CHANNELS, 1))
    course = RmsCourse(np.zeros(1), 0.5, ones, ones, np.ones(CHANNELS), ones > 1)
    best = SimpleNamespace(channel=0, against="speed")
    at = SimpleNamespace(frame_lags=np.array(frame_lags))
    last = SimpleNamespace(comparison=SimpleNamespace(linearisation=at))
    return SimpleNamespace(
        verdict="consistent",
        why="nothing stands above noise",
        extended=h,
        extended_stage=last,
        search=SimpleNamespace(named=(), unlisted=None, ranking=()),
        detectability=VISIBLE,
        signature=Signature("nothing", (), (), (), (course,), (), cast("Any", best)),
        causes=(),
        numbers=(),
        shares=(),
        pictures=(),
        gains=(),
        arm_error=None,
        remainder=(),
        something_remains=False,
        set_aside=((), ()),
        found_laws=(),
        drawing=(),
        explained=0.0,
        not_simulated="",
        before=noise,
        after=noise,
    )


def test_frames_are_late_by_their_own_clock_and_by_the_cause() -> None:
    """A camera that shows all 20 ms late, in two recordings whose clocks are 3 ms and -1 ms off beside that."""
    effect = EFFECTS["clock_offset"]
    where = effect.placements(arm_of(NECK))[0]
    camera = with_causes(as_described(NECK), (Cause(effect, where, np.array([0.02, 0.0]), {}),))
    clocks = as_json(found(camera, [0.003, -0.001]))["clocks"]
    assert [clock["recording"] for clock in clocks] == [1, 2]
    assert [clock["late_s"] for clock in clocks] == pytest.approx([0.023, 0.019], abs=1e-12)


def test_a_pair_of_look_alikes_says_which_feigns_which() -> None:
    """A tilt does 95 % of what a payload does, and a payload 30 % of what a tilt does: of these two the first alone is listed."""
    record = as_json(found(as_described(NECK), [0.0]))
    assert record["look_alikes"] == [
        {"effect": "tip_payload", "feigned_by": "base_tilt", "share": 0.95},
        {"effect": "base_tilt", "feigned_by": "clock_offset", "share": 0.91},
    ]
    names, feigned = record["isolability"]["effects"], record["isolability"]["feigned"]
    for pair in record["look_alikes"]:
        assert feigned[names.index(pair["effect"])][names.index(pair["feigned_by"])] == pair["share"]
