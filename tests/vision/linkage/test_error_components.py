"""Sigma of single frames where a codec shifts and turns whole markers, by errors that are drawn here for each marker and frame."""

import numpy as np
import pytest

from tests.vision.linkage.test_linkage_fit import NECK, camera, motion
from tests.vision.scene import corners
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import LinkageOptions

FRAMES = 300
STATED_PX = 0.03
ALONE = LinkageOptions(drift=False)


def with_errors(seed: int, shift: float, turn: float, size: float, shape: float) -> np.ndarray:
    """Corners of a moving arm, px; markers are shifted, turned, grown and bent by so many times STATED_PX, rms of a corner."""
    rng = np.random.default_rng([41, seed])
    seen = corners(NECK, motion(FRAMES))
    out = seen - seen.mean(axis=2, keepdims=True)
    out /= np.sqrt(np.mean(out**2, axis=(2, 3), keepdims=True))
    quarter = np.stack([-out[..., 1], out[..., 0]], axis=-1)
    each = (*seen.shape[:2], 1, 1)
    seen = seen + STATED_PX * shift * rng.normal(0, 1, (*seen.shape[:2], 1, 2))
    seen = seen + STATED_PX * (turn * rng.normal(0, 1, each) * quarter + size * rng.normal(0, 1, each) * out)
    return seen + STATED_PX * shape * rng.normal(0, 1, seen.shape)


def fitted(seen: np.ndarray) -> LinkageFit:
    stated = np.broadcast_to(STATED_PX**2 * np.eye(8), (*seen.shape[:2], 8, 8))
    return fit_linkage(NECK, camera(), seen, "test", covariance=stated, options=ALONE)


def spread_of_z(fit: LinkageFit) -> np.ndarray:
    """Of each joint: error of single frames without what they share, over its sigma."""
    assert fit.noise is not None
    error = fit.alpha - motion(FRAMES)
    error -= error.mean(axis=0)
    return np.sqrt(np.mean(error**2 / np.diagonal(fit.noise, axis1=1, axis2=2), axis=0))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_shifts_and_turns_of_whole_markers_are_in_sigma(seed: int) -> None:
    """Shifts are twice and turns three times the noise of single corners: 300 frames scatter z by 4 %, the estimate as much."""
    z = spread_of_z(fitted(with_errors(seed, 2.0, 3.0, 1.0, 1.0)))
    assert np.all((z > 0.85) & (z < 1.15)), z


def test_a_turn_alone_widens_most_the_joint_that_only_turns_tell() -> None:
    plain, turned = fitted(with_errors(3, 0, 0, 0, 1.0)), fitted(with_errors(3, 0, 3.0, 0, 1.0))
    assert plain.noise is not None
    assert turned.noise is not None
    wider = np.sqrt(
        np.diagonal(turned.noise, axis1=1, axis2=2).mean(0) / np.diagonal(plain.noise, axis1=1, axis2=2).mean(0)
    )
    assert wider[-1] > 1.7
    z = spread_of_z(turned)
    assert np.all((z > 0.8) & (z < 1.2)), z


@pytest.mark.parametrize("seed", [4, 5, 6])
def test_white_noise_keeps_its_sigma(seed: int) -> None:
    """Independent corners: sigma is that of the stated covariance, to 6 %."""
    fit = fitted(with_errors(seed, 0, 0, 0, 1.0))
    assert np.all(np.abs(spread_of_z(fit) - 1) < 0.12)
    assert fit.scale == pytest.approx(1.0, abs=0.03)


def test_a_marker_that_jumps_in_some_frames_does_not_widen_the_others() -> None:
    """In one frame of ten a marker is a pixel off, as under a cable: the other frames keep their sigma to 10 %."""
    seen = with_errors(7, 0, 0, 0, 1.0)
    sharp = fitted(seen)
    off = seen.copy()
    off[::10, 2] += 1.0
    covered = fitted(off)
    assert sharp.noise is not None
    assert covered.noise is not None
    kept = np.arange(FRAMES) % 10 != 0
    ratio = np.diagonal(covered.noise, axis1=1, axis2=2)[kept] / np.diagonal(sharp.noise, axis1=1, axis2=2)[kept]
    assert np.all(np.abs(np.sqrt(np.median(ratio, axis=0)) - 1) < 0.1)
