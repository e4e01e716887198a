"""Corner errors that last for many frames are in the covariance of what all frames share."""

import numpy as np
import pytest

from mechanism.description import Neck
from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.linkage.test_marker_placement import placed
from tests.vision.scene import corners
from vision.linkage import shared_fit as recording_fit
from vision.linkage.block_covariance import clustered_covariance, frame_blocks
from vision.linkage.linkage_fit import fit_linkage
from vision.linkage.shared_fit import LinkageOptions, PlacementPrior

FRAMES = 400
LAST = 0.93
"""by which an error goes on to the next frame: its memory is 14 frames"""
NOISE_PX = 0.02


def motion() -> np.ndarray:
    t = np.arange(FRAMES) / 30
    return 0.5 * np.sin(2 * np.pi * np.outer(t, [0.31, 0.47, 0.73]) + [0.0, 1.0, 2.0])


def lasting(seed: int, shape: tuple[int, ...]) -> np.ndarray:
    """Noise of NOISE_PX that goes on from frame to frame (autoregressive of first order)."""
    new = np.random.default_rng([8, seed]).normal(0, NOISE_PX, shape)
    out = new.copy()
    for k in range(1, len(out)):
        out[k] = LAST * out[k - 1] + np.sqrt(1 - LAST**2) * new[k]
    return out


def believed(seed: int) -> Neck:
    """The arm with each marker as far from where it sits as the prior expects."""
    assert NECK.markers is not None
    rng, prior = np.random.default_rng([9, seed]), PlacementPrior()
    on_bars = tuple(
        m.model_copy(
            update={
                "at": tuple(float(v) for v in np.array(m.at) + rng.normal(0, prior.at_sigma, 2)),
                "angle": float(m.angle + rng.normal(0, prior.angle_sigma)),
            }
        )
        for m in NECK.markers.on_bars
    )
    return NECK.model_copy(update={"markers": NECK.markers.model_copy(update={"on_bars": on_bars})})


def test_errors_that_last_are_in_the_covariance_of_pose_and_placement(monkeypatch: pytest.MonkeyPatch) -> None:
    """8 recordings of 13 s, errors with a memory of half a second: z of placement is 0.6 to 1.5 (96 numbers in about 40
    independent directions, 8 blocks each); taken for white noise it is over 2."""
    alpha = motion()
    exact = corners(NECK, alpha)
    seen = [exact + lasting(seed, exact.shape) for seed in range(8)]

    def spread() -> float:
        z = []
        for seed, c in enumerate(seen):
            options = LinkageOptions(PlacementPrior(), drift=False)
            placement = fit_linkage(believed(seed), camera(), c, "test", options=options).placement
            assert placement is not None
            found = np.array([[n.value, n.sigma] for n in placement.numbers])
            z.append((found[:, 0] - placed(NECK)) / found[:, 1])
        return float(np.sqrt(np.mean(np.square(z))))

    assert 0.6 < spread() < 1.5
    monkeypatch.setattr(recording_fit, "frame_blocks", lambda frames: np.zeros(frames, dtype=int))
    assert spread() > 2


def test_white_noise_keeps_its_covariance() -> None:
    """Least squares with 12 unknowns, 20 blocks, 400 seeds: the mean of the covariance is that of white noise
    and the 3 / 23 that 20 blocks leave open, within 5 %."""
    rng = np.random.default_rng(3)
    J = rng.normal(size=(20, 30, 12)) * np.geomspace(1, 100, 12)
    A = np.swapaxes(J, 1, 2) @ J
    true = np.linalg.inv(A.sum(axis=0))
    ratio = []
    for _ in range(400):
        e = 0.3 * rng.normal(size=(20, 30))
        left = e - J @ (true @ np.einsum("bij,bi->j", J, e))
        found = clustered_covariance(A, np.einsum("bij,bi->bj", J, left), np.zeros(12), 0.09)
        ratio.append(np.diag(found) / np.diag(0.09 * true))
    np.testing.assert_allclose(np.mean(ratio, axis=0), 1 + 3 / 23, atol=0.05)


def test_blocks_have_consecutive_frames_and_are_neither_short_nor_many() -> None:
    for frames in (1, 50, 700, 30_000):
        block = frame_blocks(frames)
        assert np.all(np.diff(block) >= 0)
        assert set(block) == set(range(block[-1] + 1))
        assert block[-1] < 40
        assert frames < 90 or np.bincount(block).min() >= 45
