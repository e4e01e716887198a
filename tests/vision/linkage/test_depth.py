"""Markers that lie before or behind the arm's plane, and tilted out of it, as on any real arm."""

from functools import cache

import numpy as np
import pytest

from mechanism.description import Neck
from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.linkage.test_marker_placement import motion
from tests.vision.scene import corners
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import LinkageOptions

NOISE_PX = 0.03
SEEDS = range(8)


def drawn(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Planes within 8 mm of the arm's and tilts of a degree, of four markers."""
    rng = np.random.default_rng([21, seed])
    return rng.uniform(-0.008, 0.008, 4), np.radians(rng.normal(0, 1.0, (4, 2)))


def said(neck: Neck, depth: np.ndarray) -> Neck:
    """The arm with measured depths in its description."""
    assert neck.markers is not None
    on_bars = tuple(m.model_copy(update={"depth": float(d)}) for m, d in zip(neck.markers.on_bars, depth, strict=True))
    return neck.model_copy(update={"markers": neck.markers.model_copy(update={"on_bars": on_bars})})


@cache
def seen(seed: int) -> tuple[np.ndarray, LinkageFit]:
    """True angles of 20 s, and the fit that was told nothing."""
    depth, tilt = drawn(seed)
    alpha = motion(600, 25.0, seed)
    return alpha, fit_linkage(NECK, camera(), corners(NECK, alpha, seed, NOISE_PX, depth, tilt), "test")


def bias(fit: LinkageFit, alpha: np.ndarray) -> np.ndarray:
    """Mean error of each joint, rad."""
    return np.mean(fit.alpha - alpha, axis=0)


def test_angles_are_right_and_sigma_says_how_well() -> None:
    """Three joints of 8 arms: the spread of 24 scatters by .15 about one."""
    z = []
    for seed in SEEDS:
        alpha, fit = seen(seed)
        assert fit.noise is not None
        common = np.sqrt(np.diagonal(np.mean(fit.covariance - fit.noise, axis=0)))
        assert np.max(np.abs(bias(fit, alpha))) < np.radians(0.04)
        z.append(bias(fit, alpha) / common)
    assert 0.55 < np.sqrt(np.mean(np.square(z))) < 1.45


def test_in_one_plane_the_same_corners_mean_half_a_degree() -> None:
    """Negative control: the angles of markers that are believed to lie within a hundredth of a millimetre of the arm's plane."""
    alpha, _ = seen(0)
    depth, tilt = drawn(0)
    on_bars = tuple(m.model_copy(update={"depth_sigma": 1e-5}) for m in (NECK.markers and NECK.markers.on_bars) or ())
    assert NECK.markers is not None
    flat = NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"on_bars": on_bars})})
    fit = fit_linkage(
        flat, camera(), corners(NECK, alpha, 0, NOISE_PX, depth, tilt), "test", options=LinkageOptions(drift=False)
    )
    assert np.max(np.abs(bias(fit, alpha))) > np.radians(0.2)


def test_no_camera_is_said_to_have_moved() -> None:
    assert not [seed for seed in SEEDS if seen(seed)[1].drift]


def test_planes_against_each_other_are_found() -> None:
    """All markers together may lie anywhere: only how they differ is told, and within its sigma."""
    for seed in SEEDS:
        depth, _ = drawn(seed)
        found = seen(seed)[1].depth
        error = np.array([n.value for n in found]) - depth
        error -= error.mean()
        assert np.max(np.abs(error)) < 4 * max(n.sigma for n in found)
        assert np.std(error) < 0.5 * np.std(depth)


def test_a_measured_depth_is_believed() -> None:
    """Said to a millimetre each, all four together lie where they were said to lie within half of that."""
    depth, tilt = drawn(3)
    alpha, unsaid = seen(3)
    told = fit_linkage(said(NECK, depth), camera(), corners(NECK, alpha, 3, NOISE_PX, depth, tilt), "test")
    assert abs(np.mean([n.value for n in told.depth]) - depth.mean()) < 0.002
    assert all(n.sigma < 0.0006 for n in told.depth)
    assert abs(np.mean([n.value for n in unsaid.depth])) < 1e-12  # the arm's plane is the mean of theirs
    assert np.max(np.abs(bias(told, alpha))) < np.radians(0.015)


@pytest.mark.parametrize("off", [0.005, -0.005])
def test_a_depth_that_was_measured_wrong_hardly_reaches_the_angles(off: float) -> None:
    """One marker 5 mm from where it was said to be within a millimetre: the motion tells better."""
    depth, tilt = drawn(2)
    alpha, _ = seen(2)
    wrong = depth + off * np.eye(4)[2]
    fit = fit_linkage(said(NECK, wrong), camera(), corners(NECK, alpha, 2, NOISE_PX, depth, tilt), "test")
    assert np.max(np.abs(bias(fit, alpha))) < np.radians(0.02)
