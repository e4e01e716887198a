"""The parameters that all frames of a recording share - camera pose, its drift, placement of the markers - from corners."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import Neck, markers_of
from mechanism.printed_markers import Markers
from vision.linkage.block_covariance import frame_blocks
from vision.linkage.camera_motion import (
    DriftTerm,
    MotionCandidate,
    fit_camera_motion,
    locate_step,
    scale_change,
    shift_size,
    squared_shift,
)
from vision.linkage.gauss_newton import (
    LinkageSolution,
    SharedPrior,
    fit_angles,
    fit_frames,
    refine_over_recording,
    shared_covariance,
)
from vision.linkage.initial_guess import initial_angles, initial_poses, select_frames
from vision.linkage.observed_corners import Floats, ObservedCorners, normalise_corners, whiten_corners
from vision.linkage.offset_sensitivity import offset_sensitivity
from vision.linkage.scene import PLACEMENT, Scene, SharedParameters, image_to_plane, nominal_parameters
from vision.linkage.standing_markers import side_lengths, standing_markers
from xneck_foundation.errors import Refused

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Frames = NDArray[np.intp]

MAX_FRAMES = 600
"""frames, spread over the recording, from which the shared parameters are estimated at most"""
INITIAL_FRAMES = 60
"""frames that decide between the two poses that one planar marker allows"""
TILT_SIGMA = float(np.radians(2.0))
"""rad: how far a marker is tilted out of the arm's plane, about either axis (docs/thresholds.md)"""


@dataclass(frozen=True)
class PlacementPrior:
    """How far a marker may sit from where neck.yaml has it, as standard deviations."""

    at_sigma: float = 0.002
    """m, along and across the bar"""
    angle_sigma: float = float(np.radians(2.0))
    """rad"""
    length_sigma: float | None = None
    """m, of L and b, which then are estimated too; None holds them to neck.yaml"""
    weight: float = 1.0
    """how many times as much as frames the prior counts in a fit: errors of corners come again from frame to frame"""


@dataclass(frozen=True)
class LinkageOptions:
    """Which shared parameters are estimated, and how far the corners can be trusted."""

    placement: PlacementPrior | None = None
    """prior of where each marker sits, which then is estimated; None believes neck.yaml"""
    drift: bool = True
    """whether motions of the camera are sought and corrected"""
    systematic_px: float = 0.0
    """px: standard deviation of corner offsets that stay the same over the recording, which more frames do not average out"""
    standing_px: float = 0.0
    """px: standard deviation of the offset of a marker that stands still in the picture: the same pixels err in every frame"""
    standing_weight: float = 1.0
    """how many times as much as frames that counts in a fit: errors of corners come again from frame to frame"""


@dataclass(frozen=True)
class SharedFit:
    """Camera pose, placement and drift of a recording, with the covariance of all of them."""

    scene: Scene
    image: Complex
    """(F, markers, 4): normalised corners of the whole recording, NaN where not found"""
    shared: SharedParameters
    covariance: Array
    """(p, p) of `shared.vector`"""
    variance: float
    """of a whitened coordinate: the factor on the corners' stated covariance (px^2 where none was stated)"""
    course: Array
    """(F, terms): share of each drift term that a frame has"""
    drift: tuple[DriftTerm, ...]
    prior: SharedPrior
    offset_gain: Array | None
    """(p, 8 markers): change of `shared.vector` by one standard deviation of each lasting corner offset; None without them"""

    @property
    def total_covariance(self) -> Array:
        """(p, p) of `shared.vector`, lasting offsets included."""
        gain = self.offset_gain
        return self.covariance if gain is None else self.covariance + gain @ gain.T

    def first_angles(self, frames: Frames) -> Array:
        """Initial angles of some frames, (F, N), rad."""
        return _initial_angles(self.scene, self.shared, self.image[frames])


@dataclass(frozen=True)
class _Recording:
    """The corners of a recording before the arm."""

    scene: Scene
    image: Complex
    """(F, markers, 4): normalised corners, NaN where not found"""
    corners_of: Callable[[Frames], ObservedCorners]
    """the corners of some frames, whitened"""
    time: Array | None
    """(F,), s"""
    focal: float
    """px"""


def fit_shared(
    neck: Neck,
    camera: Camera,
    corners: Array,
    where: str,
    covariance: Floats | None = None,
    time: Array | None = None,
    options: LinkageOptions = LinkageOptions(),
) -> SharedFit:
    """corners (F, markers, 4, 2), px as detected, NaN where not found; covariance (F, markers, 8, 8), px^2, of them.

    time: (F,), s, to name the moment of a drift. Raises Refused where the frames do not show what the pose needs.
    """
    markers = markers_of(neck, where)
    placement = options.placement
    scene = Scene(arm_of(neck), markers, placement is not None and placement.length_sigma is not None)
    image = normalise_corners(camera, corners)
    chosen = select_frames(markers, ~np.isnan(image[..., 0]), MAX_FRAMES, where)

    def corners_of(frames: Frames) -> ObservedCorners:
        return whiten_corners(camera, image[frames], None if covariance is None else covariance[frames])

    recording = _Recording(scene, image, corners_of, time, float(np.sqrt(camera.K[0, 0] * camera.K[1, 1])))
    nominal = nominal_parameters(scene.arm, markers, np.zeros(6))
    prior = _prior(nominal, markers, placement)
    if placement is None and options.standing_px:
        prior = _with_standing_offsets(
            prior, scene, image[chosen], options.standing_px / recording.focal, options.standing_weight
        )
    fit = _fit_chosen(recording, chosen, prior, where)
    course = np.zeros((len(image), 0))
    terms: tuple[DriftTerm, ...] = ()
    if options.drift:
        fit, prior, motions, known = fit_camera_motion(
            scene, corners_of(chosen), fit, prior, chosen, len(image), recording.focal
        )
        course, terms = _drift_terms(recording, fit, prior, chosen, motions, known)
    block = frame_blocks(len(image))
    if placement is None:
        shared, variance = fit.shared, fit.equations.variance
        spread = _covariance(fit, prior, block[chosen])
    else:
        # the least determined directions of the placement need every frame
        first = _initial_angles(scene, fit.shared, image)
        shared, spread, variance = refine_over_recording(scene, corners_of, fit, first, course, prior, block)
    gain = None
    if options.systematic_px:
        slopes = _offset_slopes(scene, corners_of(chosen), shared, course[chosen], prior, variance)
        gain = options.systematic_px / recording.focal * slopes
    return SharedFit(
        scene=scene,
        image=image,
        shared=shared,
        covariance=spread,
        variance=variance,
        course=course,
        drift=terms,
        prior=prior,
        offset_gain=gain,
    )


def _fit_chosen(recording: _Recording, chosen: Frames, prior: SharedPrior, where: str) -> LinkageSolution:
    """The fit of the chosen frames without drift, from the better of the two poses that a planar marker allows."""
    scene, image = recording.scene, recording.image
    on_bar, _ = scene.on_bars(nominal_parameters(scene.arm, scene.markers, np.zeros(6)).placement)
    few = chosen[np.unique(np.linspace(0, len(chosen) - 1, INITIAL_FRAMES).astype(int))]
    fits: list[LinkageSolution] = []
    for pose in initial_poses(scene, on_bar, image[chosen], where):
        start = nominal_parameters(scene.arm, scene.markers, pose)
        first = _initial_angles(scene, start, image[few])
        with suppress(np.linalg.LinAlgError):  # of the wrong pose all may run away
            fits.append(fit_frames(scene, recording.corners_of(few), start, first, np.zeros((len(few), 0)), prior))
    if not fits:
        raise Refused(
            where,
            "the markers do not lie as on the arm of neck.yaml",
            "check the markers' ids, bars, at, angle and size, and the lengths L and b",
        )
    freedom = 8 * int(np.count_nonzero(~np.isnan(image[few, :, 0])))
    best = min(fits, key=lambda fit: _twice_negative_log(fit, prior, freedom)).shared
    first = _initial_angles(scene, best, image[chosen])
    return fit_frames(scene, recording.corners_of(chosen), best, first, np.zeros((len(chosen), 0)), prior)


def _twice_negative_log(fit: LinkageSolution, prior: SharedPrior, freedom: int) -> float:
    """-2 log of a fit's posterior, but for a constant: what it leaves of the corners, and how far it goes from what is known.

    freedom: coordinates of the corners.
    """
    far = prior.information * (fit.shared.vector - prior.mean) ** 2
    return freedom * float(np.log(fit.equations.variance)) + float(far.sum())


def _drift_terms(
    recording: _Recording,
    fit: LinkageSolution,
    prior: SharedPrior,
    chosen: Frames,
    motions: list[MotionCandidate],
    course: Array,
) -> tuple[Array, tuple[DriftTerm, ...]]:
    """The courses over all frames, (F, terms), and the terms, of motions that a fit of the chosen frames contains.

    course: of the chosen frames, (chosen, terms). A step is placed among the frames between two chosen ones.
    """
    scene, image = recording.scene, recording.image
    square_px = squared_shift(scene, recording.corners_of(chosen), fit, course, recording.focal)
    columns = np.zeros((len(image), 0))
    terms = []
    for j, motion in enumerate(motions):
        frame = len(image) - 1
        if motion.kind == "step":
            between = np.arange(chosen[motion.index - 1] + 1, chosen[motion.index])
            angles = _initial_angles(scene, fit.shared, image[between])
            before, after = course[motion.index - 1].copy(), course[motion.index].copy()
            before[j], after[j] = 0.0, 1.0
            frame = int(chosen[motion.index - 1]) + 1
            if len(between):
                frame += locate_step(scene, recording.corners_of(between), fit, angles, before, after)
            column = (np.arange(len(image)) >= frame).astype(float)
        else:
            column = np.arange(len(image)) / max(len(image) - 1, 1)
        columns = np.column_stack([columns, column])
        start = len(prior.mean) - 6 * (len(motions) - j)
        rows = slice(start, start + 6)
        change, covariance = fit.shared.drift[j], fit.covariance[rows, rows]
        size, sigma = shift_size(change, covariance, square_px)
        terms.append(
            DriftTerm(
                kind=motion.kind,
                frame=frame,
                time=None if recording.time is None else float(recording.time[frame]),
                size_px=size,
                sigma_px=sigma,
                change=change,
                scale=scale_change(change, covariance, square_px, float(fit.shared.pose[5])),
            )
        )
    return columns, tuple(terms)


def _covariance(fit: LinkageSolution, prior: SharedPrior, block: Frames) -> Array:
    """Covariance of the shared parameters of a fit, (p, p); block: the block to which each of its frames belongs, (F,)."""
    score = np.zeros((block.max() + 1, len(prior.mean)))
    information = np.zeros((*score.shape, score.shape[1]))
    np.add.at(information, block, fit.equations.reduced)
    np.add.at(score, block, fit.equations.g_reduced)
    return shared_covariance(information, score, prior, fit.equations.variance)


def _offset_slopes(
    scene: Scene,
    observed: ObservedCorners,
    shared: SharedParameters,
    course: Array,
    prior: SharedPrior,
    variance: float,
) -> Array:
    """Derivative of the shared parameters by lasting corner offsets in normalised coordinates, (p, 8 markers)."""
    first = _initial_angles(scene, shared, observed.image)
    alpha, _ = fit_angles(scene, observed, shared, first, course, float(np.sqrt(variance)))
    sensitivity = offset_sensitivity(scene, observed, shared, alpha, course)
    free = np.flatnonzero(prior.free)
    information = sensitivity.reduced + np.diag(prior.information * variance)
    slopes = np.zeros_like(sensitivity.on_shared)
    slopes[free] = np.linalg.solve(information[np.ix_(free, free)], sensitivity.on_shared[free])
    return slopes


def _prior(nominal: SharedParameters, markers: Markers, placement: PlacementPrior | None) -> SharedPrior:
    """Pose free; depth and tilt of each marker about what is known of them; its place on the bar and the lengths about their
    nominal values where they are estimated, else held."""
    sigma = np.zeros(nominal.placement.shape)
    sigma[:, 3] = [m.depth_known[1] for m in markers.on_bars]
    sigma[:, 4:] = TILT_SIGMA
    if placement is not None:
        sigma[:, :3] = placement.at_sigma, placement.at_sigma, placement.angle_sigma
    length_sigma = (placement and placement.length_sigma) or 0.0
    known = np.concatenate([np.zeros(6), sigma.ravel(), np.full(nominal.lengths.size, length_sigma)])
    information = np.divide(1.0, known**2, out=np.zeros(len(known)), where=known > 0)
    free = known > 0
    free[:6] = True
    weight = np.ones(sigma.shape)
    if placement is not None:
        weight[:, :3] = placement.weight
    weight = np.concatenate([np.ones(6), weight.ravel(), np.ones(nominal.lengths.size)])
    return SharedPrior(nominal.vector, weight * information, free, weight)


def _with_standing_offsets(
    prior: SharedPrior, scene: Scene, image: Complex, offset: float, weight: float
) -> SharedPrior:
    """The prior with the places of markers that stand still known to `offset` only, normalised coordinates.

    image: normalised corners (F, markers, 4), NaN where not found. Such a marker counts as one measurement, not as one in every
    frame: the motion of the others tells where its bar is. weight: how many times as much as frames it counts in a fit.
    """
    size = scene.markers.size
    information, free, wider = prior.information.copy(), prior.free.copy(), prior.wider.copy()
    side = side_lengths(image)
    for k in np.flatnonzero(standing_markers(image)):
        row = slice(6 + PLACEMENT * k, 9 + PLACEMENT * k)
        information[row] = weight * (np.array([size, size, 2.0]) * offset / side[k]) ** -2
        free[row], wider[row] = True, weight
    return replace(prior, information=information, free=free, wider=wider)


def _initial_angles(scene: Scene, shared: SharedParameters, image: Complex) -> Array:
    return initial_angles(scene.arm, scene.markers, shared.placement[:, 2], image_to_plane(image, shared.pose))
