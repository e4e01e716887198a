"""Markers of anyone's video, without an arm: each one's corners, its turn in the picture, and how sure both are.

Which markers there are is looked up in frames spread over the video; these are then followed as an arm's are.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.dictionaries import marker_cells
from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series
from identification.files import joint_state
from mechanism.printed_markers import BarMarker, Markers
from vision.extract import refuse_other_size
from vision.interlacing import refuse_interlaced
from vision.linkage.lens_bow import correct_lens_bow
from vision.markers.detection import MarkerDetector
from vision.markers.dictionary_in_view import dictionary_in_view, refuse_mirrored
from vision.markers.tracking import DOUBLED, OTHER_PRINT, TrackingOptions
from vision.markers.video_tracking import MarkerTracks, track_video
from vision.noise_by_frames import noise_factor
from vision.second_prints import second_print_warnings, second_prints, without_second_prints
from vision.shutter import UNKNOWN_SHUTTER, Shutter, at_middle_row
from vision.video import Video, read_frames
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

LOOKED_AT = 40
"""frames, spread over the video, in which markers are looked for (docs/thresholds.md)"""
MIN_SIGHTINGS = 2
"""frames of those in which a marker must be found: dictionaries of few bits are seen once where there is none
(docs/thresholds.md)"""
_ANY_SIZE = 0.02
"""m: what a marker's size is given as, where no size matters"""


@dataclass(frozen=True)
class TracksOptions:
    """How markers are measured."""

    dictionary: str
    """as in neck.yaml: apriltag_36h11, aruco_4x4_50, ..."""
    shutter: Shutter = UNKNOWN_SHUTTER
    template: bool = True
    """whether corners are fitted to all grey levels of a marker, or to the edges of its square only"""


@dataclass(frozen=True)
class TracksOfMarkers:
    """Markers by id over the frames of a video, arrays (F, markers, ...)."""

    ids: tuple[int, ...]
    time: Array
    """(F,), s, of the middles of the exposures"""
    corners: Array
    """(F, markers, 4, 2), px: top left, top right, bottom right, bottom left of the upright marker; NaN where not found"""
    turn: Array
    """(F, markers), rad: of the marker's x axis in the picture, from the picture's x axis counterclockwise, without jumps of a
    whole turn; with a camera, as it would be without its lens' distortion"""
    sigma_turn: Array
    """(F, markers), rad; NaN where corners are by their edges, whose noise nobody states"""
    sigma_px: Array
    """(F, markers): standard deviation of a corner's coordinate as the grey levels tell it; NaN as above"""
    duplicates: NDArray[np.intp]
    """(markers,): frames that show a marker twice and more, and in which it is left out"""
    other_prints: NDArray[np.intp]
    """(markers,): frames that may show another print of a marker than the others do, and in which it is left out"""
    warnings: tuple[str, ...] = ()
    """sentences on what is left out"""

    @property
    def series(self) -> Series:
        """A column for each number: x1_id7, y1_id7, ..., turn_id7, sigma_turn_id7, sigma_px_id7."""
        columns: dict[str, Array] = {}
        for k, i in enumerate(self.ids):
            for corner in range(4):
                for axis, name in enumerate("xy"):
                    columns[f"{name}{corner + 1}_id{i}"] = self.corners[:, k, corner, axis]
            columns |= {
                f"turn_id{i}": self.turn[:, k],
                f"sigma_turn_id{i}": self.sigma_turn[:, k],
                f"sigma_px_id{i}": self.sigma_px[:, k],
            }
        return Series(self.time, columns)

    def as_json(self) -> dict[str, Any]:
        """The record of an extraction without an arm."""
        found = ~np.isnan(self.turn)
        return {
            "frames": len(self.time),
            "markers": [
                {
                    "id": i,
                    "seen_share": float(found[:, k].mean()),
                    "duplicates": int(self.duplicates[k]),
                    "other_prints": int(self.other_prints[k]),
                    "sigma_turn_median_rad": _median(self.sigma_turn[:, k]),
                    "sigma_px_median": _median(self.sigma_px[:, k]),
                }
                for k, i in enumerate(self.ids)
            ],
        }


@one_blas_thread
def track_markers(
    video: Video,
    options: TracksOptions,
    camera: Camera | None = None,
    workers: int = 1,
    progress: Callable[[int], object] = lambda frames: None,
) -> TracksOfMarkers:
    """All markers of a dictionary in a video; with a camera their turns are free of the lens' distortion.

    Raises Refused for a damaged video, one of woven fields, a picture size that is not the camera's,
    or where no marker of the dictionary is in view.
    """
    if camera is not None:
        refuse_other_size(video, camera)
    ids = _ids_in_view(video, options.dictionary)
    if not ids:
        view = dictionary_in_view(video)
        refuse_mirrored(video.path, view)
        other = view and view.name
        raise Refused(
            video.path,
            f"shows no marker of {options.dictionary} in {min(LOOKED_AT, video.frames)} frames spread over it"
            + (f", but markers of {other}" if other else ""),
            f"give --dictionary {other}" if other else "name the dictionary that they were printed from",
        )
    markers = _markers(options.dictionary, ids)
    tracking = TrackingOptions(options.template, options.shutter.exposure_s)
    tracks = track_video(video, markers, tracking, workers, progress)
    refuse_interlaced(video.path, tracks.time, tracks.corners, tracks.row_shift)
    others = second_prints(tracks.time, tracks.corners, tracks.status, tracks.prints, None)
    tracks = without_second_prints(tracks, others)
    corners = tracks.corners
    if camera is not None:
        cells = np.stack([marker_cells(options.dictionary, i) for i in ids]) if options.template else None
        corners = correct_lens_bow(camera, corners, cells)
    corners = at_middle_row(tracks.time, corners, video.height, options.shutter)
    turn, sigma = _turns(corners, tracks, camera)
    spread = np.full(turn.shape, np.nan)
    if tracks.covariance is not None:
        spread = np.sqrt(np.diagonal(tracks.covariance, axis1=-2, axis2=-1).mean(axis=-1, dtype=float))
    time = options.shutter.middle(tracks.time, video.height)
    turn = _unwrapped(turn)
    if tracks.covariance is not None:
        sigma = sigma * noise_factor(time, turn, sigma)
    return TracksOfMarkers(
        ids=ids,
        time=time,
        corners=corners,
        turn=turn,
        sigma_turn=sigma,
        sigma_px=spread,
        duplicates=(tracks.status == DOUBLED).sum(axis=0),
        other_prints=(tracks.status == OTHER_PRINT).sum(axis=0),
        warnings=tuple(second_print_warnings(time, others, ids)),
    )


def write_tracks(tracks: TracksOfMarkers, path: str | Path, notes: dict[str, Any]) -> None:
    """Writes MCAP (.mcap, with the notes), or .csv, .npz, .mat with the columns alone."""
    if Path(path).suffix.lower() == ".mcap":
        joint_state.write(path, {"markers": tracks.series}, {"markers": notes})
    else:
        export_series(tracks.series, path)


def _markers(dictionary: str, ids: tuple[int, ...]) -> Markers:
    return Markers(dictionary=dictionary, size=_ANY_SIZE, on_bars=tuple(BarMarker(id=i, bar=0) for i in ids))


def _ids_in_view(video: Video, dictionary: str) -> tuple[int, ...]:
    """Ids of the dictionary that are seen in at least MIN_SIGHTINGS of the frames looked at, or in the only one."""
    detector = MarkerDetector(_markers(dictionary, (0,)))
    every = max(1, video.frames // LOOKED_AT)
    sightings, looked = Counter[int](), 0
    for frame in read_frames(video.path):
        if frame.index % every:
            continue
        looked += 1
        sightings.update({i for i, _ in detector.detect_all(frame.grey) + detector.detect_small(frame.grey)})
    return tuple(sorted(i for i, count in sightings.items() if count >= min(MIN_SIGHTINGS, looked)))


def _turns(corners: Array, tracks: MarkerTracks, camera: Camera | None) -> tuple[Array, Array]:
    """Direction of each marker's x axis (F, markers), rad, and its standard deviation by the corners' covariance."""
    places = corners if camera is None else camera.rays(corners.reshape(-1, 2)).reshape(corners.shape)
    along = _along_x(places)
    # y is down in the picture
    turn = np.arctan2(-along[..., 1], along[..., 0])
    if tracks.covariance is None:
        return turn, np.full(turn.shape, np.nan)
    in_px = _along_x(corners)
    slope = np.stack([in_px[..., 1], -in_px[..., 0]], axis=-1) / np.sum(in_px**2, axis=-1, keepdims=True)
    by_corner = np.array([-1.0, 1.0, 1.0, -1.0])[:, None] * slope[..., None, :]
    by_number = by_corner.reshape(*turn.shape, 8)
    variance = np.einsum("fki,fkij,fkj->fk", by_number, tracks.covariance.astype(float), by_number)
    return turn, np.sqrt(np.maximum(variance, 0.0))


def _along_x(corners: Array) -> Array:
    """Twice the mean of the upper and the lower side, which point along the marker's x axis, (..., 2), of corners (..., 4, 2)."""
    return corners[..., 1, :] - corners[..., 0, :] + corners[..., 2, :] - corners[..., 3, :]


def _unwrapped(turn: Array) -> Array:
    """Without jumps of a whole turn from one frame in which a marker is seen to the next such frame."""
    out = turn.copy()
    for k in range(turn.shape[1]):
        seen = ~np.isnan(turn[:, k])
        out[seen, k] = np.unwrap(turn[seen, k])
    return out


def _median(values: Array) -> float | None:
    return float(np.nanmedian(values)) if np.isfinite(values).any() else None
