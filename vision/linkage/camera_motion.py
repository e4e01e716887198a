"""Did the camera move against the arm? Steps (a tripod that was knocked) and slow drift, found, sized and followed.

Each candidate - a step after any frame, a ramp over the recording - is a change of the pose, six numbers, that some frames
have and others have not. Its score test costs sums over what the fit has left (Rao): no refit for each candidate. The
statistic is divided by how much the pose's score scatters from one stretch of the recording to the next beyond
what white noise does, so that errors of the lens or of the arm's model, which come and go with the motion, are not taken for drift.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from vision.linkage.gauss_newton import LinkageSolution, Prior, extended, frame_angles, gauss_newton
from vision.linkage.observed_corners import Observed
from vision.linkage.scene import Scene

Array = NDArray[np.float64]

THRESHOLD = 32.0
"""of the largest of many chi-squares with six degrees of freedom: 110 recordings without drift gave 25 at most"""
LEAST_PX = 0.1
"""a smaller one is within what detection and lens can feign, and costs no angle worth it"""
MOST_TERMS = 6
STRETCHES = 20
LEAST_FRAMES = 40
SIGMA = np.array([0.05, 0.05, 0.05, 0.05, 0.05, 0.05])
"""rad and m, beforehand"""


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
    change: Array
    """(6,): of rvec (rad) and tvec (m)"""

    @property
    def sentence(self) -> str:
        """For a person to read."""
        when = f"at {self.time:.1f} s" if self.time is not None else f"at frame {self.frame}"
        size = f"{self.size_px:.2f} +- {self.sigma_px:.2f} px"
        if self.kind == "step":
            return f"the camera moved against the base {when}, by {size} in the picture; corrected"
        return f"the camera drifted slowly against the base, by {size} in the picture in all; corrected"


@dataclass(frozen=True)
class MotionCandidate:
    """The likeliest change of pose that a fit does not know yet."""

    kind: str
    index: int
    """of the frame, among those of the fit, from which a step holds"""
    course: Array
    """(frames of the fit,): how much of it each frame has"""
    change: Array
    statistic: float
    size_px: float


def candidate(fit: LinkageSolution, prior: Prior, position: Array, square_px: Array) -> MotionCandidate | None:
    """The likeliest drift in what a fit left over; None where the recording is too short to tell.

    position: of the fit's frames in the recording, 0..1, (F,); square_px: (6, 6), mean squared corner shift by pose.
    """
    k, frames = fit.at, len(position)
    if frames < LEAST_FRAMES:
        return None
    live = np.flatnonzero(prior.free)
    total = (k.reduced.sum(axis=0) + np.diag(prior.information * k.variance))[np.ix_(live, live)]
    inverted = np.linalg.pinv(total, hermitian=True)
    margin = max(frames // STRETCHES, 5)  # a shorter end would be one pose of the arm, which any misfit explains
    kinds = [("step", i, (np.arange(frames) >= i).astype(float)) for i in range(margin, frames - margin)]
    kinds.append(("ramp", frames - 1, position))
    courses = np.stack([course for _, _, course in kinds])
    score = courses @ k.g_reduced[:, :6]
    own = np.tensordot(courses**2, k.reduced[:, :6, :6], axes=1) + k.variance * np.diag(1 / SIGMA**2)
    across = np.tensordot(courses, k.reduced[:, :, :6], axes=1)[:, live]
    change = np.linalg.solve(own - np.swapaxes(across, 1, 2) @ inverted @ across, score[..., None])[..., 0]
    statistic = np.sum(score * change, axis=1) / k.variance
    best = int(np.argmax(statistic))
    kind, index, course = kinds[best]
    moved = np.zeros((frames, k.reduced.shape[1]))
    moved[:, live] = -inverted @ (across[best] @ change[best])
    moved[:, :6] += course[:, None] * change[best]
    left = k.g_reduced[:, :6] - np.einsum("fij,fj->fi", k.reduced[:, :6], moved)
    scatter = _scatter(left, k.reduced[:, :6, :6], k.variance)
    size = float(np.sqrt(change[best] @ square_px @ change[best]))
    return MotionCandidate(kind, index, course, change[best], float(statistic[best] / max(scatter, 1.0)), size)


def follow(
    scene: Scene,
    observed: Observed,
    fit: LinkageSolution,
    prior: Prior,
    chosen: NDArray[np.intp],
    frames: int,
    focal: float,
) -> tuple[LinkageSolution, Prior, list[MotionCandidate], Array]:
    """The fit with every significant drift as further unknowns; the candidates taken, the strongest first, and (F, terms).

    chosen: which of the recording's `frames` frames the fit has.
    """
    taken: list[MotionCandidate] = []
    course = np.zeros((len(chosen), 0))
    while len(taken) < MOST_TERMS:
        square = square_px(scene, observed, fit, course, focal)
        found = candidate(fit, prior, chosen / max(frames - 1, 1), square)
        if found is None or found.statistic < THRESHOLD or found.size_px < LEAST_PX:
            break
        taken.append(found)
        course = np.column_stack([course, found.course])
        prior = extended(prior, 1 / SIGMA**2)
        grown = replace(fit.shared, drift=np.vstack([fit.shared.drift, np.zeros(6)]))
        fit = gauss_newton(scene, observed, grown, fit.alpha, course, prior)
    return fit, prior, taken, course


def square_px(scene: Scene, observed: Observed, fit: LinkageSolution, course: Array, focal: float) -> Array:
    """Mean squared shift of a corner in the picture, px^2, as a quadratic form (6, 6) of the pose's change."""
    some = np.unique(np.linspace(0, len(course) - 1, 50).astype(int))
    by = focal * scene.by_shared(fit.shared, fit.alpha[some], course[some])[..., :6][observed.seen[some]].reshape(-1, 6)
    return (by.conj().T @ by).real / max(len(by), 1)


def size_of(change: Array, covariance: Array, square: Array) -> tuple[float, float]:
    """RMS shift of the corners, px, that a change of pose (6,) with its covariance means, and its standard deviation."""
    size = float(np.sqrt(change @ square @ change))
    by = square @ change / max(size, 1e-12)
    return size, float(np.sqrt(by @ covariance @ by))


def step_frame(scene: Scene, between: Observed, fit: LinkageSolution, alpha: Array, before: Array, after: Array) -> int:
    """How many of the frames between two of the fit lie before a step, by the cut that leaves least.

    before, after: the rows of `course`, (terms,), on either side; alpha: first angles, (F, N).
    """
    scale = float(np.sqrt(fit.at.variance))
    costs = []
    for row in (before, after):
        course = np.repeat(row[None], len(alpha), axis=0)
        costs.append(frame_angles(scene, between, fit.shared, alpha, course, scale)[1].squares)
    gain = np.concatenate([[0.0], np.cumsum(costs[0] - costs[1])])
    return int(np.argmin(gain))


def _scatter(score: Array, information: Array, variance: float) -> float:
    """Mean square of the pose's score, (F, 6), over stretches of the recording against what white noise would give."""
    squares = []
    for part in np.array_split(np.arange(len(score)), STRETCHES):
        s, a = score[part].sum(axis=0), information[part].sum(axis=0)
        squares.append(s @ np.linalg.lstsq(a, s, rcond=1e-12)[0] / variance / 6)
    return float(np.mean(squares))
