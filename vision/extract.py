"""A recorded video to joint angles."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from calibration.dictionaries import marker_cells
from identification.dataset.series import Series
from mechanism.description import Neck
from mechanism.printed_markers import Markers
from synchronisation.angles import Angles
from vision.arm_reach import arm_reach
from vision.covariance_size import steady_sizes
from vision.frame_quality import angle_gaps, frame_quality
from vision.interlacing import refuse_interlaced
from vision.late_pictures import late_pictures
from vision.light_patch import LightPatch
from vision.linkage.initial_guess import refuse_without_base
from vision.linkage.lens_bow import correct_lens_bow
from vision.linkage.linkage_fit import LinkageFit
from vision.linkage.shared_fit import LinkageOptions, PlacementPrior
from vision.markers.dictionary_in_view import dictionary_in_view, refuse_mirrored
from vision.markers.known_markers import known_markers
from vision.markers.tracking import DOUBLED, LATE, OTHER_PRINT, REPEATED, TrackingOptions
from vision.markers.video_tracking import MarkerTracks, track_video
from vision.misplaced_markers import misplacement
from vision.noise_by_frames import with_noise_by_frames
from vision.picture_scale import at_usual_scale, beating_scale, scale_warning
from vision.recorded_linkage import RecordedLinkage
from vision.repeated_pictures import repeated_pictures
from vision.second_prints import second_print_warnings, second_prints, without_second_prints
from vision.shutter import UNKNOWN_SHUTTER, Shutter
from vision.turned_prints import turned_prints
from vision.video import Segment, Video
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

SYSTEMATIC_PX = 0.006
"""px: standard deviation of corner offsets that stay the same over the whole recording (docs/thresholds.md)"""
STANDING_PX = 0.04
"""px: standard deviation of the offset of a marker that stands still, by the codec and the place of its edges among the pixels
(docs/thresholds.md)"""
_WRONG_ROW_TIME_SHARE = 0.1
"""of a row time that was said: from what difference on it is called wrong"""
_SELDOM_SEEN = 0.5
"""share of frames with a marker below which a warning names it"""
_MAX_MOMENTS = 10
"""repeated frames whose times are listed in the warning; the notes have all"""


@dataclass(frozen=True)
class ExtractionOptions:
    """What is known of the recording, and how its markers are measured."""

    shutter: Shutter = UNKNOWN_SHUTTER
    placement: PlacementPrior | None = None
    """prior of where each marker sits, which then is estimated; None believes neck.yaml"""
    template: bool = True
    """whether corners are fitted to all grey levels of a marker, or to the edges of its square only"""
    light: LightPatch | None = None
    """where a light that the controller switches is seen; its brightness is read from every frame"""

    @property
    def tracking(self) -> TrackingOptions:
        """How markers are followed from frame to frame."""
        return TrackingOptions(self.template, self.shutter.exposure_s)


@dataclass(frozen=True)
class Extraction:
    """Angles, the fit behind them, and the corners that were detected."""

    angles: Angles
    fit: LinkageFit
    corners: Array
    """(F, markers, 4, 2), px, NaN where a marker was not found; markers in neck.yaml's order"""
    quality: Series

    def as_json(self) -> dict[str, Any]:
        """The contract's record of an extraction."""
        angles = self.angles
        complete = angles.complete
        median = float(np.median(angles.sigma[complete])) if complete.any() else None
        return {
            "frames": len(angles.time),
            "frames_with_all_angles": int(complete.sum()),
            "sigma_alpha_median_rad": median,
            "corner_sigma_px": self.fit.corner_sigma_px,
            "markers": angles.notes["markers"],
            "gaps": angles.notes["gaps"],
            "repeated_frames": angles.notes["repeated_frames"],
            "late_frames": angles.notes["late_frames"],
            "warnings": angles.notes["warnings"],
            "drift": angles.notes["drift"],
            "shake": angles.notes["shake"],
            "placement": angles.notes.get("placement"),
            "depth": angles.notes["depth"],
            "row_time": angles.notes["row_time"],
            "askew": angles.notes["askew"],
            "T_camera_base": angles.notes["T_camera_base"],
        }


@one_blas_thread
def extract(
    video: Video,
    camera: Camera,
    neck: Neck,
    options: ExtractionOptions = ExtractionOptions(),
    workers: int = 1,
    progress: Callable[[int], object] = lambda frames: None,
    tracked: Mapping[Segment, MarkerTracks] = MappingProxyType({}),
) -> Extraction:
    """Angles of every frame of a video; `workers` processes share it, `progress` is called with each number of frames done.

    `tracked` holds the tracks of segments that were tracked before, by `options.tracking`: these are not read again.

    Frames that show the picture before them again, or another moment than their stamps say, have no angles
    (`notes["repeated_frames"]`, `notes["late_frames"]`). Where neck.yaml's placement of the
    markers is believed, it is compared with what the motion shows: where markers hardly sit so (`notes["askew"]`), angles are
    fitted with markers that may sit beside their places, and sigma holds that.

    Raises Refused for a damaged video, one of a single frame or of woven fields, a picture size that is not the
    camera's, or where no marker of the arm is in view.
    """
    markers = known_markers(neck, "neck.yaml")
    refuse_without_base(markers, "neck.yaml")
    refuse_other_size(video, camera)
    if video.frames < 2:
        raise Refused(
            video.path, "has one frame only, which shows no motion", "is it a picture, or was the recording cut?"
        )
    if options.light:
        options.light.refuse_outside(video.width, video.height, str(video.path))
    tracks = track_video(video, markers, options.tracking, workers, progress, options.light, tracked)
    _refuse_without_markers(video, markers, tracks)
    refuse_interlaced(video.path, tracks.time, tracks.corners, tracks.row_shift)
    others = second_prints(tracks.time, tracks.corners, tracks.status, tracks.prints, arm_reach(neck))
    tracks = without_second_prints(tracks, others)
    repeated = repeated_pictures(tracks.time, tracks.corners)
    tracks = _without(tracks, repeated, REPEATED)
    late = np.full(len(tracks.time), np.nan)
    late[~repeated] = late_pictures(tracks.time[~repeated], tracks.corners[~repeated])
    is_late = ~np.isnan(late)
    tracks = _without(tracks, is_late, LATE)
    ids = [marker.id for marker in markers.on_bars]
    cells = np.stack([marker_cells(markers.dictionary, i) for i in ids]) if options.template else None
    seen = correct_lens_bow(camera, tracks.corners, cells)
    turned = turned_prints(neck, camera, seen, str(video.path))
    scale = beating_scale(tracks.time, seen, camera)
    if scale is not None:
        seen = at_usual_scale(seen, scale, camera)
    if tracks.covariance is not None:
        tracks = replace(tracks, covariance=steady_sizes(tracks.covariance))
    # covariance as single floats: hours of them as double ones would be most of memory
    seen, covariance = turned.upright(seen, tracks.covariance)
    linkage = linkage_options(options)
    recorded = RecordedLinkage(neck, camera, video, tracks.time, seen, covariance, ~(repeated | is_late))
    done = recorded.fitted(linkage, options.shutter)
    askew = None
    if options.placement is None and (
        doubt := misplacement(neck, camera, done.corners, covariance, str(video.path), done.fit, linkage)
    ):
        prior, askew = doubt
        done = recorded.fitted(replace(linkage, placement=prior), options.shutter, done.shake)
        done = replace(done, fit=replace(done.fit, placement=None))
    corners, shutter = done.corners, done.shutter
    time = shutter.middle(tracks.time, video.height)
    fit = with_noise_by_frames(done.fit, time)
    notes = _notes(video, markers, tracks, corners, fit)
    notes["askew"] = askew
    notes["repeated_frames"] = [{"frame": int(k), "time_s": float(time[k])} for k in np.flatnonzero(repeated).tolist()]
    notes["late_frames"] = [
        {"frame": int(k), "time_s": float(time[k]), "late_s": float(late[k])} for k in np.flatnonzero(is_late)
    ]
    notes["row_time"] = _row_time_note(fit, shutter)
    notes["warnings"] = [
        *video.warnings,
        *([askew] if askew else []),
        *turned.warnings(markers),
        *second_print_warnings(time, others, ids),
        *_seldom_seen_warnings(markers, notes["markers"]),
        *_repetition_warning(time, repeated),
        *_late_warning(time, late),
        *scale_warning(scale),
        *([done.shake.sentence] if done.shake else []),
        *_row_time_warning(fit, options.shutter, shutter, video.height),
    ]
    notes["gaps"] = angle_gaps(time, fit.alpha, ids, tracks.status)
    if options.light:
        delay = options.light.delay_s(video.height, shutter)
        notes["light"] = {**asdict(options.light), "exposure_s": options.shutter.exposure_s, "later_s": delay}
    quality = frame_quality(tracks, ids, fit.residual_px, options.shutter.exposure_s)
    return Extraction(_angles(time, fit, notes, tracks.light), fit, corners, quality)


def linkage_options(options: ExtractionOptions, drift: bool = True) -> LinkageOptions:
    """What a linkage is fitted with; drift: whether motions of the camera are sought."""
    return LinkageOptions(options.placement, drift=drift, systematic_px=SYSTEMATIC_PX, standing_px=STANDING_PX)


def refuse_other_size(video: Video, camera: Camera) -> None:
    """Raises Refused where a camera was calibrated at another size of the picture than a video's."""
    if video.quarter_turns % 2 and (video.height, video.width) == camera.size:
        raise Refused(
            video.path,
            f"is tagged as turned by 90 deg, and read so: the camera was calibrated at {camera.width}x{camera.height}, of pictures "
            "as the sensor delivers them",
            "calibrate with a video that is tagged alike, or take the tag off this one",
        )
    if (video.width, video.height) != camera.size:
        raise Refused(
            video.path,
            f"is {video.width}x{video.height}, the camera was calibrated at {camera.width}x{camera.height}",
            "calibrate with pictures of the video's size",
        )


def _without(tracks: MarkerTracks, frames: NDArray[np.bool_], status: int) -> MarkerTracks:
    """The tracks without what these frames show, which is true of another moment than that of their stamps."""
    if not frames.any():
        return tracks
    tracks = tracks.without(np.broadcast_to(frames[:, None], tracks.status.shape), status)
    return replace(tracks, light=None if tracks.light is None else np.where(frames, np.nan, tracks.light))


def _seldom_seen_warnings(markers: Markers, seen: Sequence[Mapping[str, Any]]) -> list[str]:
    """A sentence for each marker that is missing in most frames; seen: of each marker, as the notes have it."""
    return [
        f"marker {marker.id} on {marker.place} was seen in {100 * told['seen_share']:.0f} % of the frames: where it is missing "
        f"the other markers tell its bar{'; is another print of it in view?' if told['duplicates'] else ''}"
        for marker, told in zip(markers.on_bars, seen, strict=True)
        if told["seen_share"] < _SELDOM_SEEN
    ]


def _late_warning(time: Array, late: Array) -> list[str]:
    """A sentence on frames that were taken so much, s, before their times (F,), s; none where there are none."""
    is_late = ~np.isnan(late)
    off = late[is_late]
    if not len(off):
        return []
    shows, their = ("frame shows", "its stamp") if len(off) == 1 else ("frames show", "their stamps")
    return [
        f"{len(off)} of {len(time)} {shows} another moment than {their}, by up to {1e3 * np.abs(off).max():.0f} ms "
        f"(at {_moments(time[is_late])} s): no angles there; are frames stamped when they are taken, or when they arrive?"
    ]


def _repetition_warning(time: Array, repeated: NDArray[np.bool_]) -> list[str]:
    """A sentence on repeated frames (F,) at times (F,), s; none where there are none."""
    count = int(repeated.sum())
    if not count:
        return []
    shows = "frame shows" if count == 1 else "frames show"
    return [
        f"{count} of {len(time)} {shows} the picture before again while the arm moves (at {_moments(time[repeated])} s): "
        "no angles there; does the camera keep up with its frame rate?"
    ]


def _moments(time: Array) -> str:
    """The first of these times, s, and whether there are more."""
    more = ", ..." if len(time) > _MAX_MOMENTS else ""
    return ", ".join(f"{t:.2f}" for t in time[:_MAX_MOMENTS]) + more


def _row_time_note(fit: LinkageFit, shutter: Shutter) -> dict[str, float | None]:
    """By how much later the row below is exposed, as the corners were corrected, and how well the motion tells it."""
    found = fit.row_time
    return {
        "used_s": shutter.row_s,
        "found_s": None if found is None else shutter.row_s + found.seconds,
        "sigma_s": None if found is None else found.sigma,
    }


def _row_time_warning(fit: LinkageFit, said: Shutter, used: Shutter, height: int) -> list[str]:
    """A sentence where the motion shows a rolling shutter that nobody spoke of, or another one than was said."""
    found = fit.row_time
    if found is None:
        return []
    shown = f"{1e6 * (used.row_s + found.seconds):.2f} +- {1e6 * found.sigma:.2f} us after the row above it"
    if not said.row_s and used.row_s:
        whole = 1e3 * abs(used.row_s) * (height - 1)
        return [f"a rolling shutter: each row is exposed {shown} ({whole:.1f} ms from first to last); corrected"]
    if said.row_s and found.is_sure and abs(found.seconds) > _WRONG_ROW_TIME_SHARE * abs(said.row_s):
        return [f"a row time of {1e6 * said.row_s:.2f} us was said, but the motion shows each row {shown}; correct it"]
    return []


def _refuse_without_markers(video: Video, markers: Markers, tracks: MarkerTracks) -> None:
    if not np.isnan(tracks.corners).all():
        return
    ids = list(tracks.foreign_ids)[:8]
    other = f", though others of the dictionary are (ids {ids})" if ids else ""
    view = None if ids else dictionary_in_view(video)
    refuse_mirrored(video.path, view)
    if view and view.name != markers.dictionary:
        raise Refused(
            video.path,
            f"no marker of neck.yaml was found in {len(tracks.time)} frames, which show markers of {view.name}",
            f"correct markers.dictionary ({markers.dictionary})",
        )
    raise Refused(
        video.path,
        f"no marker of neck.yaml was found in {len(tracks.time)} frames{other}",
        f"check markers.dictionary ({markers.dictionary}) and the ids; are markers sharp, and 2 px or more a cell?",
    )


def _notes(video: Video, markers: Markers, tracks: MarkerTracks, corners: Array, fit: LinkageFit) -> dict[str, Any]:
    """What angles.mcap says of the source, the markers, the camera's pose and the fit."""
    shares = (~np.isnan(corners[:, :, 0, 0])).mean(axis=0)
    doubled, other = ((tracks.status == status).sum(axis=0) for status in (DOUBLED, OTHER_PRINT))
    return {
        "source": video.path.name,
        "markers": [
            {
                "id": marker.id,
                "seen_share": float(shares[k]),
                "duplicates": int(doubled[k]),
                "other_prints": int(other[k]),
            }
            for k, marker in enumerate(markers.on_bars)
        ],
        "foreign_ids": list(tracks.foreign_ids)[:50],
        "T_camera_base": {
            "rvec": fit.rvec.tolist(),
            "tvec_m": fit.tvec.tolist(),
            "sigma": fit.pose_sigma.tolist(),
        },
    } | fit.notes


def _angles(time: Array, fit: LinkageFit, notes: dict[str, Any], light: Array | None) -> Angles:
    """The fit's angles with their standard deviations, whole and the part that all frames share."""
    unknown = np.isnan(fit.alpha)
    sigma = np.where(unknown, np.nan, np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2)))
    noise = fit.covariance if fit.noise is None else fit.noise
    shared = np.diagonal(fit.covariance - noise, axis1=1, axis2=2)
    common = np.where(unknown, np.nan, np.sqrt(np.maximum(shared, 0.0)))
    return Angles(time=time, alpha=fit.alpha, sigma=sigma, notes=notes, light=light, common=common)
