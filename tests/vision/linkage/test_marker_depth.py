"""Depths of markers that nobody measured are told about their mean, which the camera's distance may explain as well."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mechanism.description import markers_of, read_neck
from tests.paths import NECK_FILE
from vision.linkage.marker_placement import describe_depth
from vision.linkage.scene import PLACEMENT

NECK = read_neck(NECK_FILE)
COUNT = len(markers_of(NECK, "neck.yaml").on_bars)
OWN_M, COMMON_M = 0.3e-3, 2e-3
"""standard deviations of each marker's depth by itself, and of what all have in common"""


def fit(depth: np.ndarray) -> Any:
    """With such depths, m; all else is known to a metre, or a radian."""
    covariance = np.eye(6 + PLACEMENT * COUNT)
    rows = 6 + PLACEMENT * np.arange(COUNT) + 3
    covariance[np.ix_(rows, rows)] = OWN_M**2 * np.eye(COUNT) + COMMON_M**2
    placement = np.zeros((COUNT, PLACEMENT))
    placement[:, 3] = depth
    return SimpleNamespace(shared=SimpleNamespace(placement=placement), total_covariance=covariance)


def test_what_all_depths_have_in_common_is_in_neither_value_nor_sigma() -> None:
    depth = 0.005 + 1e-3 * np.arange(COUNT)
    found = describe_depth(NECK, fit(depth))
    assert [n.value for n in found] == pytest.approx(1e-3 * (np.arange(COUNT) - (COUNT - 1) / 2))
    assert [n.sigma for n in found] == pytest.approx([OWN_M * np.sqrt(1 - 1 / COUNT)] * COUNT)


def test_where_a_depth_was_measured_all_are_told_from_the_arms_plane() -> None:
    assert NECK.markers is not None
    first, *others = NECK.markers.on_bars
    on_bars = (first.model_copy(update={"depth": 0.005}), *others)
    measured = NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"on_bars": on_bars})})
    depth = 0.005 + 1e-3 * np.arange(COUNT)
    found = describe_depth(measured, fit(depth))
    assert [n.value for n in found] == pytest.approx(depth)
    assert [n.sigma for n in found] == pytest.approx([np.hypot(OWN_M, COMMON_M)] * COUNT)
