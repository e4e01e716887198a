"""The markers of an arm: which are printed, and where each sits."""

from collections.abc import Iterator
from math import pi
from typing import Annotated

from pydantic import Field, model_validator

from xneck_foundation.one_line import listed
from xneck_foundation.strict_yaml import Strict

Angle = Annotated[float, Field(ge=-pi, le=pi)]

WORKSHOP_DEPTH_SIGMA = 0.010
"""m: how far from the arm's plane a marker sits, where nobody measured it (docs/thresholds.md)"""
MEASURED_DEPTH_SIGMA = 0.001
"""m, of a depth that was measured without saying how well (docs/thresholds.md)"""


class BarMarker(Strict):
    """Where a marker sits: its middle `at` in its bar's frame, and its x axis' `angle` against the bar's.

    A bar may lie before or behind the arm's plane, and its marker with it (`depth`).

    Its bar is a horizontal one (`bar`: 0 is the base) or a diagonal one (`diagonal`: A2 is mechanism 2's from bottom left to
    top right, B2 the one from bottom right to top left). A bar's frame has its origin at the bar's middle and x along it,
    a diagonal's from its lower to its upper end.
    """

    id: Annotated[int, Field(ge=0, le=100_000)]
    """number of the marker in its dictionary; each once"""
    bar: Annotated[int, Field(ge=0)] | None = None
    """the bar that carries it: 0 is the base, which needs one, i the top bar of mechanism i"""
    diagonal: Annotated[str, Field(pattern=r"^[AB][1-9][0-9]{0,2}$")] | None = None
    """instead of bar: A2 is mechanism 2's diagonal from bottom left to top right, B2 the one from bottom right to top left"""
    at: tuple[Annotated[float, Field(ge=-1, le=1)], Annotated[float, Field(ge=-1, le=1)]] = (0.0, 0.0)
    """m, the marker's middle from the bar's middle: along the bar, and across it; by a caliper"""
    angle: Angle = 0.0
    """rad, of the marker's upper edge against the bar, counter-clockwise; 0 where it is upright when the arm stands straight"""
    depth: Annotated[float, Field(ge=-0.5, le=0.5)] | None = None
    """m, of the marker from the arm's plane towards the camera, where it was measured; by a rule"""
    depth_sigma: Annotated[float, Field(gt=0, le=0.5)] | None = None
    """m, standard deviation of that measurement"""

    @property
    def depth_known(self) -> tuple[float, float]:
        """What is known of the depth before any recording: its value and standard deviation, m."""
        if self.depth is None:
            return 0.0, self.depth_sigma or WORKSHOP_DEPTH_SIGMA
        return self.depth, self.depth_sigma or MEASURED_DEPTH_SIGMA

    @model_validator(mode="after")
    def _one_bar(self) -> "BarMarker":
        if (self.bar is None) == (self.diagonal is None):
            found = "neither" if self.bar is None else f"bar: {self.bar} and diagonal: {self.diagonal}"
            raise ValueError(f"expected either `bar` or `diagonal`, found {found}")
        return self

    @property
    def mechanism(self) -> int | None:
        """Number of the mechanism, from 1, whose diagonal bar carries the marker; None on a horizontal bar."""
        return None if self.diagonal is None else int(self.diagonal[1:])

    @property
    def place(self) -> str:
        """The bar in words: `bar 1`, `diagonal A2`."""
        return f"bar {self.bar}" if self.diagonal is None else f"diagonal {self.diagonal}"


class Markers(Strict):
    """The printed markers: all of one dictionary and size (side of the black square)."""

    dictionary: str
    """what they are printed from: apriltag_36h11, aruco_4x4_50 or another of OpenCV's, in small letters"""
    size: Annotated[float, Field(ge=0.002, le=1.0)]
    """m, side of the black square; measure the print"""
    on_bars: Annotated[tuple[BarMarker, ...], Field(min_length=1, max_length=4096)]
    """which marker sits where"""


def marker_doubts(markers: Markers, joints: int) -> Iterator[str]:
    """What no camera will tell of an arm of so many joints, or not well, as no marker is there to tell it, in words."""
    told = {marker.bar if marker.mechanism is None else marker.mechanism for marker in markers.on_bars}
    if 0 not in {marker.bar for marker in markers.on_bars}:
        yield "no marker sits on the base (bar 0): `xneck extract` needs one there"
    last = max(bar or 0 for bar in told)
    if last < joints:
        yield f"no marker tells joint {listed(str(j) for j in range(last + 1, joints + 1))}: put one on bar {joints}"
    between = [str(bar) for bar in range(1, last) if bar not in told]
    if between:
        yield f"bar {listed(between)} has no marker: the joints on both sides of it follow from the bars beyond, less surely"
