"""Did the camera move against the arm? Detection and estimation of steps (a tripod that was knocked) and of slow drift.

Each candidate - a step after any frame, a ramp over the recording - is a change of the pose, six numbers, that some frames
have and others have not. Rao's score test needs only sums over the residuals, no refit for each candidate. The statistic is
divided by how much more the pose's score scatters from one stretch of the recording to the next than white noise does, so
that errors of the lens or of the arm's model, which come and go with the motion, are not taken for drift.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.linkage.block_covariance import MIN_BLOCK_FRAMES
from vision.linkage.gauss_newton import LinkageSolution, SharedPrior, extend_prior, fit_angles, fit_frames
from vision.linkage.observed_corners import ObservedCorners
from vision.linkage.scene import Scene

Array = NDArray[np.float64]

MIN_STATISTIC = 32.0
"""least score statistic of a motion: the largest of many chi-squares with six degrees of freedom (docs/thresholds.md)"""
MIN_SIZE_PX = 0.2
"""px: least RMS shift of the corners that counts as a motion; detection and lens can imitate smaller ones (docs/thresholds.md)"""
MIN_SIZE_CORNER_SIGMAS = 5.0
"""standard deviations of a single frame's corner: the same, as a codec draws what stands still anew at key frames
(docs/thresholds.md)"""
MIN_SIZE_UNCHECKED_PX = 0.5
"""px: the same in recordings too short to tell how errors come and go (docs/thresholds.md)"""
MIN_SIZE_SIGMAS = 3.0
"""standard deviations: least size of a motion once it is fitted (docs/thresholds.md)"""
MAX_TERMS = 6
"""motions that are estimated at most (docs/thresholds.md)"""
STRETCHES = 20
"""parts of the recording, at most, over which the scatter of the score is taken (docs/thresholds.md)"""
MIN_STRETCHES = 10
"""parts of which each is longer than a codec's errors last: with fewer the scatter is not known (docs/thresholds.md)"""
MIN_APART = 5
"""frames of a fit from one step to the next: nearer ones cannot be told from each other (docs/thresholds.md)"""
MIN_FRAMES = 40
"""frames below which no motion is sought (docs/thresholds.md)"""
MAX_REST_SHARE = 0.1
"""of the mean squared shift: what a change of the picture's scale may leave of a motion, beside chance (docs/thresholds.md)"""
POSE_CHANGE_SIGMA = np.array([0.05, 0.05, 0.05, 0.05, 0.05, 0.05])
"""rad and m: prior standard deviation of a change of the pose (docs/thresholds.md)"""


@dataclass(frozen=True)
class DriftTerm:
    """One change of the camera's pose in the course of the recording."""

    kind: str
    """`step` or `ramp` (from nothing at the first frame to all of it at the last)"""
    frame: int
    """the first frame after a step; the last frame of a ramp"""
    time: float | None
    """s, of that frame, where times are known"""
    size_px: float
    """by how much the markers' corners moved in the picture, RMS"""
    sigma_px: float
    """standard deviation of `size_px`"""
    change: Array
    """(6,): change of rvec (rad) and tvec (m)"""
    scale: float | None = None
    """relative change of the picture's scale, where that is all that the motion did"""

    @property
    def sentence(self) -> str:
        """What happened, in words."""
        when = f"at {self.time:.1f} s" if self.time is not None else f"at frame {self.frame}"
        size = f"{self.size_px:.2f} +- {self.sigma_px:.2f} px"
        if self.scale is not None:
            course = when if self.kind == "step" else "slowly"
            what = f"the picture's scale changed {course} by {100 * self.scale:+.2f} %, {size}"
            return f"{what}: a focus that breathes, or a camera that came nearer or went away; corrected"
        if self.kind == "step":
            return f"the camera moved against the base {when}, by {size} in the picture; corrected"
        return f"the camera drifted slowly against the base, by {size} in the picture in all; corrected"


@dataclass(frozen=True)
class MotionCandidate:
    """The likeliest change of pose that a fit does not contain yet."""

    kind: str
    index: int
    """first frame of a step, counted among the frames of the fit"""
    course: Array
    """(frames of the fit,): share of the change that each frame has, 0..1"""
    change: Array
    """(6,): change of rvec (rad) and tvec (m)"""
    statistic: float
    """score statistic over the scatter of the score"""
    size_px: float
    """by how much the change moves the markers' corners in the picture, RMS"""


def likeliest_motion(
    fit: LinkageSolution,
    prior: SharedPrior,
    position: Array,
    square_px: Array,
    stretches: int,
    known: Sequence[MotionCandidate] = (),
) -> MotionCandidate | None:
    """The likeliest motion in the residuals of a fit, beside those that are `known`; None where the recording is too short to tell.

    position: where in the recording each frame of the fit lies, 0..1, (F,); square_px: as `squared_shift` gives it, (6, 6), px^2;
    stretches: parts of the recording over which the scatter of the score is taken.
    """
    equations, frames = fit.equations, len(position)
    if frames < MIN_FRAMES:
        return None
    free = np.flatnonzero(prior.free)
    total = (equations.reduced.sum(axis=0) + np.diag(prior.information * equations.variance))[np.ix_(free, free)]
    size_of = np.sqrt(np.maximum(np.diag(total), 1e-300))  # unknowns of any unit
    inverted = np.linalg.pinv(total / np.outer(size_of, size_of), hermitian=True) / np.outer(size_of, size_of)
    margin = max(
        frames // STRETCHES, 5
    )  # a shorter end would show one pose of the arm, where any misfit looks like a step
    steps = [motion.index for motion in known if motion.kind == "step"]
    apart = [i for i in range(margin, frames - margin) if all(abs(i - step) >= MIN_APART for step in steps)]
    kinds = [("step", i, (np.arange(frames) >= i).astype(float)) for i in apart]
    if all(motion.kind == "step" for motion in known):
        kinds.append(("ramp", frames - 1, position))
    if not kinds:
        return None
    courses = np.stack([course for _, _, course in kinds])
    score = courses @ equations.g_reduced[:, :6]
    information = np.tensordot(courses**2, equations.reduced[:, :6, :6], axes=1)
    cross = np.tensordot(courses, equations.reduced[:, :, :6], axes=1)[:, free]
    told = information - np.swapaxes(cross, 1, 2) @ inverted @ cross
    change = _with_prior_only(told, score, equations.variance)
    statistic = np.sum(score * change, axis=1) / equations.variance
    best = int(np.argmax(statistic))
    kind, index, course = kinds[best]
    step = np.zeros((frames, equations.reduced.shape[1]))
    step[:, free] = -inverted @ (cross[best] @ change[best])
    step[:, :6] += course[:, None] * change[best]
    score_after = equations.g_reduced[:, :6] - np.einsum("fij,fj->fi", equations.reduced[:, :6], step)
    scatter = _scatter(score_after, equations.reduced[:, :6, :6], equations.variance, stretches)
    size = float(np.sqrt(change[best] @ square_px @ change[best]))
    return MotionCandidate(
        kind=kind,
        index=index,
        course=course,
        change=change[best],
        statistic=float(statistic[best] / max(scatter, 1.0)),
        size_px=size,
    )


def _with_prior_only(information: Array, score: Array, variance: float) -> Array:
    """Changes of pose (K, 6) by the scores (K, 6) of K candidates, with their prior added to the information (K, 6, 6).

    What rounding makes negative of the information of a change that the other unknowns imitate is none."""
    unit = np.outer(POSE_CHANGE_SIGMA, POSE_CHANGE_SIGMA) / variance
    value, direction = np.linalg.eigh(information * unit)
    along = np.einsum("kij,ki->kj", direction, score * POSE_CHANGE_SIGMA / variance)
    return POSE_CHANGE_SIGMA * np.einsum("kij,kj->ki", direction, along / (1 + np.maximum(value, 0.0)))


def fit_camera_motion(
    scene: Scene,
    observed: ObservedCorners,
    fit: LinkageSolution,
    prior: SharedPrior,
    chosen: NDArray[np.intp],
    frames: int,
    focal: float,
) -> tuple[LinkageSolution, SharedPrior, list[MotionCandidate], Array]:
    """The fit with every significant motion as further unknowns, its prior, the motions (strongest first) and their courses.

    chosen: which of the recording's `frames` frames the fit has, (F,); the courses are of shape (F, motions).
    """
    motions: list[MotionCandidate] = []
    course = np.zeros((len(chosen), 0))
    stretches = min(STRETCHES, frames // MIN_BLOCK_FRAMES)
    least_px = MIN_SIZE_PX if stretches >= MIN_STRETCHES else MIN_SIZE_UNCHECKED_PX
    corner_px = focal * float(np.median(observed.sigma[observed.visible]))
    while len(motions) < MAX_TERMS:
        square_px = squared_shift(scene, observed, fit, course, focal)
        motion = likeliest_motion(fit, prior, chosen / max(frames - 1, 1), square_px, max(stretches, 1), motions)
        if motion is None or motion.statistic < MIN_STATISTIC or motion.size_px < least_px:
            break
        with_motion = np.column_stack([course, motion.course])
        extended = extend_prior(prior, 1 / POSE_CHANGE_SIGMA**2)
        grown = replace(fit.shared, drift=np.vstack([fit.shared.drift, np.zeros(6)]))
        after = fit_frames(scene, observed, grown, fit.alpha, with_motion, extended)
        size, sigma = shift_size(after.shared.drift[-1], after.covariance[-6:, -6:], square_px)
        noise_px = corner_px * float(np.sqrt(after.equations.variance))
        if size < max(MIN_SIZE_SIGMAS * sigma, MIN_SIZE_CORNER_SIGMAS * noise_px):
            break
        motions.append(motion)
        fit, prior, course = after, extended, with_motion
    return fit, prior, motions, course


def squared_shift(scene: Scene, observed: ObservedCorners, fit: LinkageSolution, course: Array, focal: float) -> Array:
    """Quadratic form (6, 6) that gives the mean squared shift of the corners, px^2, for a change of the pose."""
    sample = np.unique(np.linspace(0, len(course) - 1, 50).astype(int))
    by_pose = focal * scene.by_shared(fit.shared, fit.alpha[sample], course[sample])[..., :6][
        observed.visible[sample]
    ].reshape(-1, 6)
    return (by_pose.conj().T @ by_pose).real / max(len(by_pose), 1)


def shift_size(change: Array, covariance: Array, square: Array) -> tuple[float, float]:
    """RMS shift of the corners by a change of the pose (6,) with covariance (6, 6), and its standard deviation, px."""
    size = float(np.sqrt(change @ square @ change))
    slope = square @ change / max(size, 1e-12)
    return size, float(np.sqrt(slope @ covariance @ slope))


def scale_change(change: Array, covariance: Array, square: Array, distance: float) -> float | None:
    """Relative change of the picture's scale by which a change of the pose (6,) is explained, None where more has moved.

    Of a plane that faces the camera a lens of longer focal length and a camera that is nearer make one picture. square: as
    `squared_shift` gives it; distance: m, of the base along the optical axis.
    """
    nearer = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    amount = float(nearer @ square @ change / (nearer @ square @ nearer))
    rest = change - amount * nearer
    by_chance = float(np.trace(covariance @ square))
    if rest @ square @ rest > MAX_REST_SHARE * (change @ square @ change) + MIN_SIZE_SIGMAS**2 * by_chance:
        return None
    return -amount / distance


def locate_step(
    scene: Scene, between: ObservedCorners, fit: LinkageSolution, alpha: Array, before: Array, after: Array
) -> int:
    """How many of the frames between two frames of the fit lie before a step: the cut with the least squared residuals.

    before, after: rows of the courses, (motions,), on either side of the step; alpha: initial angles, (F, N), rad.
    """
    scale = float(np.sqrt(fit.equations.variance))
    costs = []
    for row in (before, after):
        course = np.repeat(row[None], len(alpha), axis=0)
        costs.append(fit_angles(scene, between, fit.shared, alpha, course, scale)[1].squares)
    gain = np.concatenate([[0.0], np.cumsum(costs[0] - costs[1])])
    return int(np.argmin(gain))


def _scatter(score: Array, information: Array, variance: float, stretches: int) -> float:
    """Mean square of the pose's score, (F, 6), summed over stretches of the recording, over that of white noise."""
    squares = []
    for part in np.array_split(np.arange(len(score)), stretches):
        s, a = score[part].sum(axis=0), information[part].sum(axis=0)
        squares.append(s @ np.linalg.lstsq(a, s, rcond=1e-12)[0] / variance / 6)
    return float(np.mean(squares))
