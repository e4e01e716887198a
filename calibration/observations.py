"""Views of a board from many pictures, and why the other pictures were left out."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from calibration.board import Board, Chessboard
from calibration.board_mismatch import describe_mismatch
from calibration.corner_detection import MIN_CORNERS, BoardVariant, BoardView, CornerDetector, prevailing_size
from calibration.pictures import Picture
from calibration.view_information import view_information
from xneck_foundation.errors import Refused

MIN_SHARPNESS = 0.7
"""sharpness of a view over the upper quartile of all, below which a video's frame counts as blurred (docs/thresholds.md)"""


@dataclass(frozen=True)
class LeftOut:
    """A picture that was not used, and why."""

    name: str
    why: str


@dataclass(frozen=True)
class Observations:
    """The views of a board in a set of pictures."""

    views: tuple[BoardView, ...]
    left_out: tuple[LeftOut, ...]
    image_size: tuple[int, int]  # width, height, px
    notes: tuple[str, ...] = ()
    variant: BoardVariant = field(default_factory=BoardVariant)


def observe_board(pictures: Iterable[Picture], board: Board) -> Observations:
    """Find `board` in every picture; memory holds one picture at a time.

    Raises Refused for pictures of different sizes, for none with the board, and where the pictures show a chessboard
    of another size. Pictures of identical content count once.
    """
    detector = CornerDetector(board)
    views: list[BoardView] = []
    left_out: list[LeftOut] = []
    contents: dict[bytes, str] = {}
    first, image_size = "", (0, 0)
    for picture in pictures:
        size = (picture.grey.shape[1], picture.grey.shape[0])
        if not contents:
            first, image_size = picture.name, size
        if size != image_size:
            raise Refused(
                picture.name,
                f"is {size[0]} x {size[1]} px, {first} is {image_size[0]} x {image_size[1]} px",
                "calibrate with pictures of one camera at one resolution, turned the same way",
            )
        digest = hashlib.blake2b(np.ascontiguousarray(picture.grey).data, digest_size=16).digest()
        if digest in contents:
            left_out.append(LeftOut(picture.name, f"the same picture as {contents[digest]}"))
            continue
        contents[digest] = picture.name
        view = detector.detect(picture)
        if view is None:
            left_out.append(LeftOut(picture.name, "the board was not found"))
        else:
            views.append(view)
    if not contents:
        raise Refused("pictures", "none given", "name picture files, a folder or a video")
    _refuse_wrong_board(detector, views, len(contents))
    variant = detector.variant or BoardVariant()
    return Observations(tuple(views), tuple(left_out), image_size, variant.notes(), variant)


def without_hidden_corners(observations: Observations) -> Observations:
    """The views without corners that no saddle fits (under a reflection, a finger, at the picture's edge)."""
    views = [view if view.sigma is None else view.of(np.isfinite(view.sigma)) for view in observations.views]
    hidden = sum(len(view.corner_ids) for view in observations.views) - sum(len(view.corner_ids) for view in views)
    few = [LeftOut(view.name, "too few clear corners") for view in views if len(view.corner_ids) < MIN_CORNERS]
    notes = (f"{hidden} corners are hidden or damaged (a reflection, a finger) and left out",) if hidden else ()
    return replace(
        observations,
        views=tuple(view for view in views if len(view.corner_ids) >= MIN_CORNERS),
        left_out=(*observations.left_out, *few),
        notes=(*observations.notes, *notes),
    )


def distinct_views(observations: Observations, limit: int = 30, apart: float = 0.01) -> Observations:
    """At most `limit` sharp and distinct views out of many (the frames of a video).

    Each next view is the one that adds most to the information on the camera (to its determinant); where no rough camera can be
    estimated, the one whose outline lies farthest from those chosen. `apart` is the least difference between the outlines of two
    views, as a share of the picture's diagonal. Views less than 0.7 times as sharp as the upper quartile are not considered.
    Frames without the board are counted in a note, not named.
    """
    views = observations.views
    if not views:
        return observations
    sharpness = np.array([view.sharpness for view in views])
    diagonal = float(np.hypot(*observations.image_size))
    outlines = _outlines(views) / diagonal
    candidates = sharpness >= MIN_SHARPNESS * np.quantile(sharpness, 0.75)
    # partial views have an uncertain outline and less information: they come after whole ones
    counts = np.array([len(view.corner_ids) for view in views])
    weight = np.where(candidates, np.sqrt(counts / counts.max()), 0.0)
    information = view_information(views, observations.image_size)
    known = 1e-4 * np.eye(8)
    chosen = [int(np.argmax(weight * sharpness))]
    distance = np.full(len(views), np.inf)
    while len(chosen) < limit:
        distance = np.minimum(distance, np.sqrt(np.mean((outlines - outlines[chosen[-1]]) ** 2, axis=(1, 2))))
        score = np.where(distance >= apart, distance, 0.0) * weight
        if information is not None:
            known = known + information[chosen[-1]]
            gain = np.linalg.slogdet(known + information)[1] - np.linalg.slogdet(known)[1]
            score = np.where(score > 0, gain, 0.0)
        best = int(np.argmax(score))
        if score[best] <= 0.0:
            break
        chosen.append(best)
    kept = tuple(views[i] for i in sorted(chosen))
    blurred = int(np.sum(~candidates))
    note = (
        f"{len(views) + len(observations.left_out)} frames looked at, {len(views)} with the board, "
        f"{blurred} of them blurred; {len(kept)} distinct views kept"
    )
    return Observations(kept, (), observations.image_size, (*observations.notes, note), observations.variant)


def _outlines(views: Sequence[BoardView]) -> np.ndarray:
    """Where four corners of a common rectangle of the board fall in each view, shape (n, 4, 2), px."""
    points = np.concatenate([view.object_points[:, :2] for view in views])
    low, high = points.min(axis=0), points.max(axis=0)
    rectangle = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    outlines = np.empty((len(views), 4, 2))
    for index, view in enumerate(views):
        # an affine map stays finite where a homography of a few corners does not
        plane = np.column_stack([view.object_points[:, :2], np.ones(len(view.image_points))])
        affine, *_ = np.linalg.lstsq(plane, view.image_points, rcond=None)
        perspective = np.column_stack([rectangle, np.ones(4)]) @ affine
        nearest = np.linalg.norm(view.object_points[None, :, :2] - rectangle[:, None], axis=2).argmin(axis=1)
        # detected corners of the rectangle replace the affine ones, so that perspective counts too
        exact = np.linalg.norm(view.object_points[nearest, :2] - rectangle, axis=1) < 1e-9
        outlines[index] = np.where(exact[:, None], view.image_points[nearest], perspective)
    return outlines


def _refuse_wrong_board(detector: CornerDetector, views: list[BoardView], pictures: int) -> None:
    """Raises Refused where the pictures show another board, or none."""
    board = detector.board
    mismatch = None if views else describe_mismatch(board, detector.rejected)
    if mismatch is not None:
        raise Refused("board", f"the pictures show {mismatch}", "describe the board as it is printed")
    if isinstance(board, Chessboard):
        size = prevailing_size(board, detector.detected_sizes)
        if size is not None:
            raise Refused(
                "board",
                f"the pictures show a chessboard of {size[0]} x {size[1]} inner corners, "
                f"not {board.columns} x {board.rows}",
                "correct columns and rows (they count inner corners)",
            )
    if views:
        return
    if detector.markers_without_board:
        raise Refused(
            "board",
            f"{detector.markers_without_board} of {pictures} pictures show markers of its dictionary but not the board "
            "as described",
            "check columns, rows, square and marker",
        )
    raise Refused("board", f"not found in any of {pictures} pictures", f"expected: {board.title}")
