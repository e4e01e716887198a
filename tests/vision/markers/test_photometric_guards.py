"""What each precaution of the template fit is for: clipped pixels, the perspective's prior, the blur where the fit fails."""

from dataclasses import replace

import numpy as np
import pytest

import vision.markers.photometric_solver as solver
from samples.generator.closeup import picture, square
from tests.vision.markers.test_photometric import CLEAN, OPTICS, REST, views
from vision.markers.edge_pixels import select_pixels
from vision.markers.photometric import EDGE_SD_PX, MarkerFit, MarkerStart, _fallback, fit_markers
from vision.markers.planar_motion import homography, move_corners

OVEREXPOSED = replace(CLEAN, white=280.0, black=60.0, noise=2.0)
"""white beyond what the camera shows: cut off at 255"""


def test_pixels_that_are_cut_off_are_not_used() -> None:
    """0 and 255 say only that it was so dark or bright, or more; every other level is used."""
    grey, truth, start = views(60, CLEAN, 1, 1)[0]
    whole = np.clip(grey, 2, 253)
    selected = select_pixels(whole, [start.cells], truth[None], homography(truth[None]), REST[None], OPTICS).used[0]
    levels = whole.copy()
    levels[::3] = np.where(grey[::3] > 128, 255, 254)
    levels[1::3] = np.where(grey[1::3] > 128, 1, 0)
    pixels = select_pixels(levels, [start.cells], truth[None], homography(truth[None]), REST[None], OPTICS)
    shown, used = pixels.grey[0][selected], pixels.used[0][selected]
    assert {0.0, 1.0, 254.0, 255.0} <= set(shown.tolist())
    np.testing.assert_array_equal(used, (shown > 0) & (shown < 255))
    assert pixels.clipped_share[0] == pytest.approx(1 - used.mean())


def test_an_overexposed_marker_is_not_biased() -> None:
    """Cut-off white moves every edge outwards: errors of corners along the diagonal have no common part beyond their sigma."""
    outward, sigma = [], []
    for grey, truth, start in views(60, OVEREXPOSED, 4):
        fit = fit_markers(grey, [start], OPTICS)[0]
        assert not fit.fell_back
        assert fit.clipped > 0.1
        away = truth - truth.mean(axis=0)
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        outward.append(float(np.mean(np.sum((fit.corners - truth) * away, axis=1))))
        direction = away.ravel() / 4
        sigma.append(float(np.sqrt(direction @ fit.covariance @ direction)))
    z = np.array(outward) / np.array(sigma)
    assert abs(z.mean()) < 4 / np.sqrt(len(z))
    assert np.sqrt(np.mean(z**2)) < 1 + 4 / np.sqrt(2 * len(z))


def settled(grey: np.ndarray, start: MarkerStart, monkeypatch: pytest.MonkeyPatch, iterations: int) -> MarkerFit:
    """The fit after just so many iterations."""
    monkeypatch.setattr(solver, "LINEAR_PX", 0.0)
    monkeypatch.setattr(solver, "MAX_ITERATIONS", iterations)
    return fit_markers(grey, [start], OPTICS)[0]


def perspective(corners: np.ndarray) -> np.ndarray:
    """What a marker's coordinates are divided by, but for 1: (g, h) of 1 + g u + h v."""
    H = homography(corners[None])[0]
    return H[2, :2] / H[2, 2]


def test_the_prior_of_the_perspective_stays_where_the_start_was(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a marker that tells far less than the prior, the perspective is the start's after any number of iterations: the prior is
    about the start, and does not run ahead of the estimate. A marker that tells more has its own, which is none."""
    truth = square(30, 0.3, np.array([28.0, 28.0]), (0.0, 0.0))
    start = move_corners(homography(truth[None]), np.array([[0.02, 0, 0, 0, 0, 0, 0.02, -0.02]]))[0]
    _, _, marker = views(30, CLEAN, 1, 1)[0]
    grey = picture(marker.cells, truth, 58, CLEAN, np.random.default_rng(0))
    np.testing.assert_allclose(perspective(start), [-0.02, 0.02], atol=1e-3)
    for prior_sd, share in ((1e-4, 1.0), (0.05, 0.0)):
        monkeypatch.setattr(solver, "PERSPECTIVE_SD", prior_sd)
        for iterations in (3, 8):
            fit = settled(grey, MarkerStart(start, marker.cells, REST), monkeypatch, iterations)
            assert not fit.fell_back
            np.testing.assert_allclose(perspective(fit.corners), share * perspective(start), atol=0.1 * 0.02)


@pytest.mark.parametrize("smear_px", [0.0, 1.0, 12.0])
def test_corners_of_the_edges_alone_are_as_unsure_as_they_are_smeared(smear_px: float) -> None:
    """A corner is somewhere along its way during the exposure: a uniform error of the way's length, 1/12 of its square."""
    grey, _, start = views(60, CLEAN, 1, 1)[0]
    motion = np.array([[1.0, 0.0], [0.0, -0.5], [0.2, 0.2], [0.3, 0.0]]) * smear_px
    fit = _fallback(grey, replace(start, motion=motion), OPTICS)
    assert np.isfinite(fit.corners).all()
    np.testing.assert_allclose(fit.covariance, (EDGE_SD_PX**2 + smear_px**2 / 12) * np.eye(8))
    assert fit.fell_back
    assert fit.blurred == (smear_px > 1.5)


def test_a_light_that_was_wrong_is_found_anew_or_the_fit_is_none() -> None:
    """Where the light of the frame before explains no pixel of this one, as when the gain halves, nothing is learnt from none:
    such a fit had a covariance of zero."""
    cells = views(40, CLEAN, 1, 1)[0][2].cells
    corners = square(40.0, 0.2, np.full(2, 48.0))
    dim = replace(CLEAN, black=15.0, white=60.0, ground=30.0)
    grey = picture(cells, corners, 96, dim, np.random.default_rng(4))
    too_bright = np.array([150.0, 0.0, 0.0, 20.0, 0.0, 0.0])
    fit = fit_markers(grey, [MarkerStart(corners + 0.2, cells, REST, too_bright)], OPTICS)[0]
    assert not fit.fell_back
    assert np.abs(fit.corners - corners).max() < 0.5
    assert np.diag(fit.covariance).min() > 1e-5
