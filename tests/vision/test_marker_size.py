"""Markers of another size than neck.yaml says, on corners that another geometry placed."""

import re

import pytest

from mechanism.description import Neck
from tests.vision.linkage.test_linkage_fit import NECK, camera, motion
from tests.vision.scene import corners
from vision.turned_prints import turned_prints
from xneck_foundation.errors import Refused

SEEN = corners(NECK, motion(60), 0)
MARKERS = NECK.markers
assert MARKERS is not None
SIZE_MM = 1e3 * MARKERS.size


def described(share: float) -> Neck:
    """The arm as described by someone who takes its markers for so many times as large as they are."""
    assert MARKERS is not None
    return NECK.model_copy(update={"markers": MARKERS.model_copy(update={"size": share * MARKERS.size})})


@pytest.mark.parametrize("share", [0.1, 0.5, 0.8, 1.25, 2.0, 10.0])
def test_another_size_is_named_with_the_true_one(share: float) -> None:
    """Angles were refused without a word on the size: every marker was in view, and none of the frames had angles."""
    with pytest.raises(Refused, match="if they were") as refused:
        turned_prints(described(share), camera(), SEEN, "video")
    told = re.search(r"if they were ([0-9.]+) mm a side", str(refused.value))
    assert told is not None
    assert float(told[1]) == pytest.approx(SIZE_MM, rel=0.02)


@pytest.mark.parametrize("share", [0.95, 1.0, 1.05])
def test_a_size_within_what_a_base_behind_the_arm_makes_is_left(share: float) -> None:
    """Control: such a factor says nothing of the size."""
    turned_prints(described(share), camera(), SEEN, "video")


@pytest.mark.parametrize("share", [0.8, 1.25])
def test_lengths_that_are_off_are_named_beside_the_size(share: float) -> None:
    """Only their ratio is seen: which of both is wrong is left to who measures."""
    mechanisms = [m.model_copy(update={"L": share * m.L, "b": share * m.b, "r": share * m.r}) for m in NECK.mechanisms]
    with pytest.raises(Refused, match=f"L and b there must be about {1 / share:.2g} times as large"):
        turned_prints(NECK.model_copy(update={"mechanisms": mechanisms}), camera(), SEEN, "video")


def test_one_marker_beside_its_place_is_no_size() -> None:
    """Control: no factor brings it back."""
    assert MARKERS is not None
    first, *rest = MARKERS.on_bars
    moved = rest[-1].model_copy(update={"at": (rest[-1].at[0] + 0.03, rest[-1].at[1])})
    markers = MARKERS.model_copy(update={"on_bars": [first, *rest[:-1], moved]})
    turned_prints(NECK.model_copy(update={"markers": markers}), camera(), SEEN, "video")
