"""Markers that are turned by quarters, or exchanged, on corners that another geometry placed."""

import numpy as np
import pytest

from tests.vision.linkage.test_linkage_fit import NECK, camera, motion
from tests.vision.scene import corners
from vision.linkage.linkage_fit import fit_linkage
from vision.turned_prints import turned_prints
from xneck_foundation.errors import Refused

FRAMES = 60
SEEN = corners(NECK, motion(FRAMES), 0)
MARKERS = SEEN.shape[1]


def turned(quarters: list[int]) -> np.ndarray:
    """What a detector says of the same markers, each printed turned by so many quarters: its corners begin at another one."""
    return np.stack([np.roll(SEEN[:, k], -quarter, axis=1) for k, quarter in enumerate(quarters)], axis=1)


@pytest.mark.parametrize(
    "quarters",
    [[quarter] * MARKERS for quarter in range(4)]
    + [[quarter if k == marker else 0 for k in range(MARKERS)] for marker, quarter in ((0, 1), (1, 1), (2, 3), (3, 2))]
    + [[1, 3] + [2] * (MARKERS - 2)],
    ids=str,
)
def test_turned_prints_are_told_and_read_as_described(quarters: list[int]) -> None:
    """None of them (negative control), all alike as of another library, one of them, and each otherwise."""
    found = turned_prints(NECK, camera(), turned(quarters), "video")
    assert found.quarters == tuple(quarters)
    assert NECK.markers is not None
    assert bool(found.warnings(NECK.markers)) is any(quarters)
    upright, covariance = found.upright(turned(quarters), None)
    np.testing.assert_array_equal(upright, SEEN)
    assert covariance is None


def test_a_covariance_is_turned_with_its_corners() -> None:
    """Each corner's own variance names it."""
    found = turned_prints(NECK, camera(), turned([2] * MARKERS), "video")
    named = np.zeros((FRAMES, MARKERS, 8, 8), dtype=np.float32)
    named[...] = np.diag([0, 0, 1, 1, 2, 2, 3, 3])
    _, covariance = found.upright(turned([2] * MARKERS), named)
    assert covariance is not None
    np.testing.assert_array_equal(covariance[0, 0].diagonal(), [2, 2, 3, 3, 0, 0, 1, 1])
    assert named[0, 0, 0, 0] == 0


def test_upside_down_prints_give_the_same_angles() -> None:
    """Which is what it is for; without it they are nowhere near, or there are none."""
    upside_down = turned([2] * MARKERS)
    upright, _ = turned_prints(NECK, camera(), upside_down, "video").upright(upside_down, None)
    said = fit_linkage(NECK, camera(), upright, "video").alpha
    np.testing.assert_allclose(said, motion(FRAMES), atol=0.02)


@pytest.mark.parametrize("pair", [(0, 1), (1, 2), (0, MARKERS - 1)])
def test_exchanged_markers_are_named(pair: tuple[int, int]) -> None:
    """They lie decimetres beside their places as they are described."""
    order = list(range(MARKERS))
    order[pair[0]], order[pair[1]] = pair[1], pair[0]
    assert NECK.markers is not None
    ids = [marker.id for marker in NECK.markers.on_bars]
    with pytest.raises(Refused, match=f"marker {ids[pair[0]]} lies where neck.yaml has {ids[pair[1]]}"):
        turned_prints(NECK, camera(), SEEN[:, order], "video")


@pytest.mark.parametrize("share", [0.95, 1.05])
def test_a_marker_size_that_is_wrong_turns_nothing(share: float) -> None:
    """Markers lie beside their places then, all of them, however they are turned."""
    assert NECK.markers is not None
    neck = NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"size": share * NECK.markers.size})})
    assert not any(turned_prints(neck, camera(), SEEN, "video").quarters)
