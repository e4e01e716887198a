"""The shape of a printed board as an estimate: a sheet that was glued on bows, and printers stretch one axis more than the other.

Every model is linear in its parameters: corner = nominal + sum of modes (+ an offset for each corner, in the model `free`).
Modes and offsets contain no motion of the whole board, which is its pose, and no change of scale, since no picture shows the
size of a board: the columns' pitch is taken as stated.
"""

from dataclasses import dataclass

import numpy as np

SHAPE_NAMES = ("bow_x", "bow_y", "aspect")
SHAPE_SIGMA = (np.inf, np.inf, 0.003)
"""prior standard deviations of the numbers SHAPE_NAMES: bows have none, the aspect that of a printer (docs/thresholds.md)"""
OFFSET_SIGMA = (0.002, 0.002, 0.005)
"""prior standard deviation of a free corner's offset along x, y, z, in squares (0.05 and 0.13 mm for squares of 25 mm)
(docs/thresholds.md)"""


@dataclass(frozen=True)
class ShapeModel:
    """Which parameters of the board's shape are estimated."""

    name: str
    free: tuple[str, ...] = ()  # of SHAPE_NAMES
    offsets: bool = False  # whether each corner has a free offset


SHAPE_MODELS = {
    model.name: model
    for model in (
        ShapeModel("rigid"),
        ShapeModel("aspect", ("aspect",)),
        ShapeModel("bowed", ("bow_x", "bow_y")),
        ShapeModel("bowed, aspect", SHAPE_NAMES),
        ShapeModel("free", (), True),
    )
}
"""Models to choose from, the simplest first; each is part of a later one (`free` contains all, up to its prior)."""


@dataclass(frozen=True)
class BoardShape:
    """The estimated shape of a board, in the frame of the nominal corners."""

    model: ShapeModel
    ids: np.ndarray  # corner ids, ascending, shape (c,)
    nominal: np.ndarray  # as board.yaml has them, shape (c, 3), m
    modes: np.ndarray  # displacements of the corners by each of SHAPE_NAMES at 1, shape (3, c, 3)
    values: np.ndarray  # bow over x and over y (how far the rim lies behind the middle, m), aspect - 1, shape (3,)
    offsets: np.ndarray  # shape (c, 3), m

    @property
    def points(self) -> np.ndarray:
        """The estimated corners, shape (c, 3), m."""
        return self.nominal + np.tensordot(self.values, self.modes, 1) + self.offsets

    def of(self, ids: np.ndarray) -> np.ndarray:
        """The estimated corners with these ids, shape (k, 3), m."""
        return self.points[np.searchsorted(self.ids, ids)]

    @property
    def bow(self) -> np.ndarray:
        """Sagitta along x and y by the least-squares bow of the estimated corners, for every model, shape (2,), m."""
        shapes = self.modes[:2, :, 2].T
        return np.linalg.lstsq(shapes, (self.points - self.nominal)[:, 2], rcond=None)[0]


def flat_board(ids: np.ndarray, nominal: np.ndarray) -> BoardShape:
    """A board whose corners are the nominal ones."""
    return BoardShape(
        model=SHAPE_MODELS["rigid"],
        ids=ids,
        nominal=nominal,
        modes=shape_modes(nominal),
        values=np.zeros(3),
        offsets=np.zeros_like(nominal),
    )


def shape_modes(nominal: np.ndarray) -> np.ndarray:
    """Displacements of the corners by each of SHAPE_NAMES at 1, shape (3, c, 3); the bows contain no motion of the board."""
    low, high = nominal[:, :2].min(axis=0), nominal[:, :2].max(axis=0)
    unit = (2 * nominal[:, :2] - low - high) / np.maximum(high - low, 1e-12)
    plane = np.column_stack([np.ones(len(unit)), unit])
    squares = unit**2
    bows = squares - plane @ np.linalg.lstsq(plane, squares, rcond=None)[0]
    displacements = np.zeros((3, len(nominal), 3))
    displacements[:2, :, 2] = bows.T
    displacements[2, :, 1] = nominal[:, 1] - nominal[:, 1].mean()
    return displacements


def offset_basis(nominal: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the free offsets, shape (3 c, 3 c - 11).

    It contains no motion of the board, and in the plane no shear and no keystone, which no printer makes but a principal point
    imitates. Scale is invisible in pictures, and the aspect is a mode of its own.
    """
    x, y = (nominal[:, :2] - nominal[:, :2].mean(axis=0)).T / max(float(np.ptp(nominal[:, :2])), 1e-12)
    one, zero = np.ones_like(x), np.zeros_like(x)
    pairs = ((one, zero), (zero, one), (x, zero), (y, zero), (zero, x), (zero, y), (x * x, x * y), (x * y, y * y))
    c = len(x)
    plane, _ = np.linalg.qr(np.array([np.concatenate(pair) for pair in pairs]).T, mode="complete")
    out, _ = np.linalg.qr(np.column_stack([one, x, y]), mode="complete")
    basis = np.zeros((c, 3, 3 * c - 11))
    basis[:, :2, : 2 * c - 8] = plane[:, 8:].reshape(2, c, -1).transpose(1, 0, 2)
    basis[:, 2, 2 * c - 8 :] = out[:, 3:]
    return basis.reshape(3 * c, -1)


def offset_sigma(nominal: np.ndarray) -> np.ndarray:
    """Prior standard deviation of a corner's offset along x, y and z, shape (3,), m."""
    from_first = np.linalg.norm(nominal - nominal[0], axis=1)
    return float(np.min(from_first[from_first > 0])) * np.array(OFFSET_SIGMA)
