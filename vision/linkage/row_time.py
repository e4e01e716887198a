"""How long after the row above it each row of a rolling shutter is exposed, as the moving arm itself shows it.

A corner is seen where it was when its own row was exposed: off by its velocity times its row's delay. Angles can follow some of
that, but not what one bar's corners do at different rows, nor bars at different heights. So the time from row to row is one more
number that all frames share. A codec drags what moves, and each corner by another time: these are nuisances, without which the
corners of a single moving marker seem to tell a row time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.camera import Camera
from vision.linkage.block_covariance import clustered_covariance, frame_blocks
from vision.linkage.gauss_newton import extend_prior, solve_scaled
from vision.linkage.linkage_equations import linkage_equations
from vision.linkage.observed_corners import Floats, whiten_corners
from vision.linkage.shared_fit import SharedFit
from vision.shutter import velocity_at

Array = NDArray[np.float64]

MAX_FRAMES = 600
"""frames, spread over the recording, that are asked"""
MIN_READOUT_S = 1.5e-3
"""s: no rolling shutter goes over its rows faster; what looks like a faster one is what compression and light do to moving markers
(docs/thresholds.md)"""
LAG_S = 3e-4
"""s: by how much a corner of a moving marker is found early or late all the time, by compression and light, standard deviation
(docs/thresholds.md)"""
SURE_SIGMAS = 6.0
"""standard deviations from which a row time is one (docs/thresholds.md)"""


@dataclass(frozen=True)
class RowTime:
    """Time from the exposure of a row to that of the row below it, beyond what corners were corrected by."""

    seconds: float
    sigma: float
    rows: int
    """of the picture"""

    @property
    def is_sure(self) -> bool:
        """Whether chance, and what the arm's model lacks, would hardly look like it."""
        return abs(self.seconds) > max(SURE_SIGMAS * self.sigma, MIN_READOUT_S / self.rows)


def row_time(
    fit: SharedFit, camera: Camera, corners: Array, time: Array, alpha: Array, covariance: Floats | None
) -> RowTime | None:
    """By a fit to corners (F, markers, 4, 2), px, at times (F,), s, with its angles (F, N), rad; None where nothing moves.

    covariance: of the corners, as `fit_linkage` takes it. The standard deviation follows from the scatter over the recording.
    """
    known = np.flatnonzero(np.isfinite(alpha).all(axis=1))
    if len(known) < 2:
        return None
    frames = known[np.unique(np.linspace(0, len(known) - 1, MAX_FRAMES).astype(int))]
    near = np.unique(np.clip(frames[:, None] + [-1, 0, 1], 0, len(time) - 1))
    moving = velocity_at(
        time[near], np.stack([fit.image[near].real, fit.image[near].imag], axis=-1), np.searchsorted(near, frames)
    )
    rows = corners[frames, ..., 1] - (camera.height - 1) / 2
    velocity = np.nan_to_num(moving[..., 0] + 1j * moving[..., 1])
    column = (np.nan_to_num(rows) * velocity)[..., None]
    if not column.any():
        return None
    # in units in which it does about as much as the others
    size = 1 / float(np.sqrt(np.mean(np.abs(column) ** 2)))
    count = velocity[0].size
    lags = velocity[..., None] * np.eye(count).reshape(*velocity.shape[1:], count)
    asked = np.concatenate([size * column, lags], axis=-1)
    observed = whiten_corners(camera, fit.image[frames], None if covariance is None else covariance[frames])
    scale = float(np.sqrt(fit.variance))
    prior = extend_prior(fit.prior, np.append(0.0, np.full(count, LAG_S**-2)))
    free, known_before = prior.free, prior.information[prior.free]
    equations = linkage_equations(fit.scene, observed, fit.shared, alpha[frames], fit.course[frames], 0, scale, asked)
    information, score = equations.reduced[:, free][:, :, free], equations.g_reduced[:, free]
    total = information.sum(axis=0) + np.diag(known_before * fit.variance)
    beside = (prior.mean - np.append(fit.shared.vector, np.zeros(1 + count)))[free]
    right = score.sum(axis=0) + known_before * fit.variance * beside
    change = solve_scaled(total, right)
    block = frame_blocks(len(alpha))[frames]
    by_block = np.zeros((block.max() + 1, *total.shape)), np.zeros((block.max() + 1, len(total)))
    np.add.at(by_block[0], block, information)
    np.add.at(by_block[1], block, score - information @ change)
    spread = clustered_covariance(*by_block, known_before, fit.variance)
    at = -1 - count
    return RowTime(size * float(change[at]), size * float(np.sqrt(spread[at, at])), camera.height)
