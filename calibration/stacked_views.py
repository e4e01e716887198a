"""All views of a board as arrays with a row for each view and a column for each corner, so that nothing loops over corners."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calibration.board_shape import offset_basis
from calibration.corner_detection import BoardView


@dataclass(frozen=True)
class StackedViews:
    """n views of a board of c corners."""

    ids: np.ndarray  # of the corners that any view shows, ascending, shape (c,)
    nominal: np.ndarray  # board frame, shape (c, 3), m
    pixels: np.ndarray  # zero where not visible, shape (n, c, 2), px
    visible: np.ndarray  # is the corner in the view, shape (n, c)

    def of(self, index: np.ndarray | Sequence[int]) -> "StackedViews":
        """The given views only."""
        return StackedViews(self.ids, self.nominal, self.pixels[index], self.visible[index])

    @cached_property
    def offset_basis(self) -> np.ndarray:
        """Basis of the free offsets of the corners, shape (3 c, 3 c - 11)."""
        return offset_basis(self.nominal)

    @property
    def counts(self) -> np.ndarray:
        """Number of corners in each view, shape (n,)."""
        return self.visible.sum(axis=1)


def stack_views(views: Sequence[BoardView]) -> StackedViews:
    """Stack views of one board."""
    corner_ids = np.concatenate([view.corner_ids for view in views])
    ids, first, place = np.unique(corner_ids, return_index=True, return_inverse=True)
    view_of = np.repeat(np.arange(len(views)), [len(view.corner_ids) for view in views])
    pixels = np.zeros((len(views), len(ids), 2))
    visible = np.zeros((len(views), len(ids)), bool)
    pixels[view_of, place] = np.concatenate([view.image_points for view in views])
    visible[view_of, place] = True
    return StackedViews(ids, np.concatenate([view.object_points for view in views])[first], pixels, visible)
