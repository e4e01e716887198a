"""The shape of a printed board as an estimate: a sheet that was glued on bows, and printers stretch one way more than the other.

Every model is linear in its numbers: corner = nominal + sum of modes (+ an offset of its own, in the model `free`).
Modes and offsets move no board as a whole: that the poses do. What stretches both ways alike is left out too, since no
picture tells the size of a board; the columns' pitch is believed.
"""

from dataclasses import dataclass

import numpy as np

SHAPE_NAMES = ("bow_x", "bow_y", "aspect")
SHAPE_SIGMA = (np.inf, np.inf, 0.003)
"""what is believed of NAMES beforehand: printers stretch by a few parts in a thousand, and where boards are seldom turned
about the line of sight the aspect looks like that of the focal lengths"""
OFFSET_SIGMA = (0.002, 0.002, 0.005)
"""what is believed of a free corner's offset before the pictures speak, in squares (0.05 and 0.13 mm for squares of 25 mm):
held-out errors on real sets hardly change from half to twice as much"""


@dataclass(frozen=True)
class ShapeModel:
    """Which numbers of the board's shape are estimated."""

    name: str
    free: tuple[str, ...] = ()  # of NAMES
    offsets: bool = False  # a free offset for each corner


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
"""From the simplest on; each is a part of a later one (`free` holds all up to its prior)."""


@dataclass(frozen=True)
class BoardShape:
    """Where a board's corners really are, in the frame of the nominal ones."""

    model: ShapeModel
    ids: np.ndarray  # corner ids, ascending, shape (c,)
    nominal: np.ndarray  # as board.yaml has them, shape (c, 3), m
    modes: np.ndarray  # what each of NAMES at 1 moves, shape (3, c, 3)
    values: np.ndarray  # bow over x and over y (how far the rim lies behind the middle, m), aspect - 1, shape (3,)
    offsets: np.ndarray  # shape (c, 3), m

    @property
    def points(self) -> np.ndarray:
        """The corners as estimated, shape (c, 3), m."""
        return self.nominal + np.tensordot(self.values, self.modes, 1) + self.offsets

    def of(self, ids: np.ndarray) -> np.ndarray:
        """The estimated corners with these ids, shape (k, 3), m."""
        return self.points[np.searchsorted(self.ids, ids)]

    @property
    def bow(self) -> np.ndarray:
        """Sagitta along x and y, whatever the model: the least-squares bow of the estimated corners, shape (2,), m."""
        shapes = self.modes[:2, :, 2].T
        return np.linalg.lstsq(shapes, (self.points - self.nominal)[:, 2], rcond=None)[0]


def flat_board(ids: np.ndarray, nominal: np.ndarray) -> BoardShape:
    """A board as it was meant."""
    return BoardShape(SHAPE_MODELS["rigid"], ids, nominal, shape_modes(nominal), np.zeros(3), np.zeros_like(nominal))


def shape_modes(nominal: np.ndarray) -> np.ndarray:
    """What each of NAMES at 1 moves, shape (3, c, 3); the bows without what a pose could do."""
    low, high = nominal[:, :2].min(axis=0), nominal[:, :2].max(axis=0)
    unit = (2 * nominal[:, :2] - low - high) / np.maximum(high - low, 1e-12)
    plane = np.column_stack([np.ones(len(unit)), unit])
    squares = unit**2
    bows = squares - plane @ np.linalg.lstsq(plane, squares, rcond=None)[0]
    out = np.zeros((3, len(nominal), 3))
    out[:2, :, 2] = bows.T
    out[2, :, 1] = nominal[:, 1] - nominal[:, 1].mean()
    return out


def offset_basis(nominal: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the free offsets, shape (3 c, 3 c - 11).

    What a pose could do is not in it, nor what a printer or a sheet of paper cannot do and a principal point can: in the
    plane no shear and no keystone. Scale is not seen in pictures at all, and the aspect is a model of its own.
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
