"""What all frames of a recording share - camera pose, its drift, placement of the markers - from corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from mechanism.arm import arm_of
from mechanism.description import Neck, markers_of
from vision.linkage.block_covariance import blocks_of
from vision.linkage.camera_motion import DriftTerm, follow, size_of, square_px, step_frame
from vision.linkage.gauss_newton import LinkageSolution, Prior, by_blocks, frame_angles, gauss_newton, offsets, polished
from vision.linkage.initial_guess import first_angles, first_poses, shared_frames
from vision.linkage.observed_corners import Observed, normalise, observed
from vision.linkage.scene import Scene, Shared, nominal, onto_plane

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FRAMES = 600
"""at most so many, spread over the recording, are used for what all frames share"""
START_FRAMES = 60
"""so many decide between the two poses that one planar marker allows"""


@dataclass(frozen=True)
class PlacementPrior:
    """How far a marker may sit from where neck.yaml has it, as standard deviations."""

    at_sigma: float = 0.002
    """m, along and across the bar"""
    angle_sigma: float = float(np.radians(2.0))
    """rad"""
    length_sigma: float | None = None
    """m, of L and b, which then are estimated too; None holds them to neck.yaml"""


@dataclass(frozen=True)
class SharedFit:
    """Camera pose, placement and drift of a recording, with the covariance of all of them."""

    scene: Scene
    image: Complex
    """(F, markers, 4): normalised corners of the whole recording, NaN where not seen"""
    shared: Shared
    covariance: Array
    """(p, p) of `shared.vector`"""
    variance: float
    """of a whitened number: by what the corners' stated covariance is to be multiplied (px^2 where none was stated)"""
    course: Array
    """(F, terms): how much of each drift term a frame has"""
    drift: tuple[DriftTerm, ...]
    offset_gain: Array | None
    """(p, 8 markers): by how much one standard deviation of each lasting corner offset moves `shared`; None where they are
    taken to be none"""

    @property
    def whole_covariance(self) -> Array:
        """(p, p) of `shared.vector`, lasting offsets included."""
        gain = self.offset_gain
        return self.covariance if gain is None else self.covariance + gain @ gain.T

    def first_angles(self, frames: NDArray[np.intp]) -> Array:
        """A start for the angles of some frames, (F, N), rad."""
        return _first_angles(self.scene, self.shared, self.image[frames])


def fit_shared(
    neck: Neck,
    camera: Camera,
    corners: Array,
    where: str,
    covariance: Array | None = None,
    time: Array | None = None,
    placement: PlacementPrior | None = None,
    drift: bool = True,
    systematic_px: float = 0.0,
) -> SharedFit:
    """corners (F, markers, 4, 2), px as detected, NaN where not found; covariance (F, markers, 8, 8), px^2, of them.

    time: (F,), s, to name the moment of a drift. systematic_px: standard deviation of corner offsets that stay the same over the
    recording, which more frames do not average out. Raises Refused where the frames do not show what the pose needs.
    """
    markers = markers_of(neck, where)
    free_lengths = placement is not None and placement.length_sigma is not None
    scene = Scene(arm_of(neck), markers, free_lengths)
    image = normalise(camera, corners)
    focal = float(np.sqrt(camera.K[0, 0] * camera.K[1, 1]))
    chosen = shared_frames(markers, ~np.isnan(image[..., 0]), FRAMES, where)

    def taken(frames: NDArray[np.intp]) -> Observed:
        return observed(camera, image[frames], None if covariance is None else covariance[frames])

    plain = nominal(scene.arm, markers, np.zeros(6))
    placed = (plain.placement[:, 0] + 1j * plain.placement[:, 1])[:, None] + (
        np.exp(1j * plain.placement[:, 2:]) * scene.square
    )
    prior = _prior(plain, placement)
    few = chosen[np.unique(np.linspace(0, len(chosen) - 1, START_FRAMES).astype(int))]
    fits: list[LinkageSolution] = []
    for pose in first_poses(scene, placed, image[chosen], where):
        start = nominal(scene.arm, markers, pose)
        first = _first_angles(scene, start, image[few])
        fits.append(gauss_newton(scene, taken(few), start, first, np.zeros((len(few), 0)), prior))
    best = min(fits, key=lambda fit: fit.at.variance).shared
    seen = taken(chosen)
    fit = gauss_newton(scene, seen, best, _first_angles(scene, best, image[chosen]), np.zeros((len(chosen), 0)), prior)
    course = np.zeros((len(image), 0))
    terms: list[DriftTerm] = []
    if drift:
        fit, prior, found, known = follow(scene, seen, fit, prior, chosen, len(image), focal)
        square = square_px(scene, seen, fit, known, focal)
        for j, c in enumerate(found):
            frame = len(image) - 1
            if c.kind == "step":
                between = np.arange(chosen[c.index - 1] + 1, chosen[c.index])
                angles = _first_angles(scene, fit.shared, image[between])
                before, after = known[c.index - 1].copy(), known[c.index].copy()
                before[j], after[j] = 0.0, 1.0
                frame = int(chosen[c.index - 1]) + 1
                if len(between):
                    frame += step_frame(scene, taken(between), fit, angles, before, after)
                column = (np.arange(len(image)) >= frame).astype(float)
            else:
                column = np.arange(len(image)) / max(len(image) - 1, 1)
            course = np.column_stack([course, column])
            start = len(prior.mean) - 6 * (len(found) - j)
            at = slice(start, start + 6)
            size, sigma = size_of(fit.shared.drift[j], fit.covariance[at, at], square)
            moment = None if time is None else float(time[frame])
            terms.append(DriftTerm(c.kind, frame, moment, size, sigma, fit.shared.drift[j]))
    block = blocks_of(len(image))
    if placement is None:
        shared, variance = fit.shared, fit.at.variance
        spread = _spread(fit, prior, block[chosen])
    else:
        # the weakest directions of the placement want every frame
        first = _first_angles(scene, fit.shared, image)
        shared, spread, variance = polished(scene, taken, fit, first, course, prior, block)
    gain = None
    if systematic_px:
        gain = systematic_px / focal * _offset_gain(scene, seen, shared, course[chosen], prior, variance)
    return SharedFit(scene, image, shared, spread, variance, course, tuple(terms), gain)


def _spread(fit: LinkageSolution, prior: Prior, block: NDArray[np.intp]) -> Array:
    """Covariance of the shared numbers of a fit, (p, p); block: of its frames, (F,)."""
    score = np.zeros((block.max() + 1, len(prior.mean)))
    information = np.zeros((*score.shape, score.shape[1]))
    np.add.at(information, block, fit.at.reduced)
    np.add.at(score, block, fit.at.g_reduced)
    return by_blocks(information, score, prior, fit.at.variance)


def _offset_gain(scene: Scene, seen: Observed, shared: Shared, course: Array, prior: Prior, variance: float) -> Array:
    """d shared / d corner offsets that stay the same over the recording, (p, 8 markers), by normalised coordinate."""
    first = _first_angles(scene, shared, seen.image)
    alpha, _ = frame_angles(scene, seen, shared, first, course, float(np.sqrt(variance)))
    pulled = offsets(scene, seen, shared, alpha, course)
    live = np.flatnonzero(prior.free)
    information = pulled.reduced + np.diag(prior.information * variance)
    out = np.zeros_like(pulled.on_shared)
    out[live] = np.linalg.solve(information[np.ix_(live, live)], pulled.on_shared[live])
    return out


def _prior(plain: Shared, placement: PlacementPrior | None) -> Prior:
    information = np.zeros(len(plain.vector))
    free = np.zeros(len(information), dtype=bool)
    free[:6] = True
    if placement is not None:
        count = plain.placement.size
        sigma = [placement.at_sigma, placement.at_sigma, placement.angle_sigma]
        information[6 : 6 + count] = np.tile(1 / np.square(sigma), len(plain.placement))
        free[6 : 6 + count] = True
        if placement.length_sigma is not None:
            information[6 + count :] = 1 / placement.length_sigma**2
            free[6 + count :] = True
    return Prior(plain.vector, information, free)


def _first_angles(scene: Scene, shared: Shared, image: Complex) -> Array:
    return first_angles(scene.arm, scene.markers, shared.placement[:, 2], onto_plane(image, shared.pose))
