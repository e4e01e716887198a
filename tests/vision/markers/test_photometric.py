"""The photometric fit against pictures of an independent renderer, `samples.generator.closeup`."""

from dataclasses import replace

import numpy as np
import pytest

import vision.markers.photometric_solver
from benchmarks.marker_angle import angle_slopes, in_plane_angle
from benchmarks.markers import FAMILY, START_PX, bound
from calibration.dictionaries import marker_cells
from samples.generator.closeup import Flaws, picture, square
from tests.vision.markers.cramer_rao import angle_bound, corner_bound
from vision.markers.photometric import MarkerFit, MarkerStart, fit_markers
from vision.markers.planar_motion import CORNERS, corner_slopes, homography, move_corners
from vision.markers.template import Optics

COUNT = 20
OPTICS = Optics(sigma=0.8, bleed=0.0, sigma_sd=0.05, bleed_sd=0.05)
CLEAN = Flaws()
REST = np.zeros((4, 2))


def views(side: int, flaws: Flaws, seed: int, count: int = COUNT) -> list[tuple[np.ndarray, np.ndarray, MarkerStart]]:
    """Pictures, true corners, and starts half a pixel off."""
    made = []
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        cells = marker_cells(FAMILY, int(rng.integers(0, 500)))
        size = int(1.9 * side + 24)
        tilt = tuple(rng.uniform(-0.02, 0.02, 2))
        corners = square(side, rng.uniform(-np.pi, np.pi), (size - 1) / 2 + rng.uniform(-0.5, 0.5, 2), tilt)
        start = MarkerStart(corners + rng.normal(0, START_PX, (4, 2)), cells, np.tile(flaws.motion, (4, 1)))
        made.append((picture(cells, corners, size, flaws, rng), corners, start))
    return made


def fits(side: int, flaws: Flaws, seed: int = 1, optics: Optics = OPTICS) -> list[tuple[np.ndarray, MarkerFit]]:
    return [(truth, fit_markers(grey, [start], optics)[0]) for grey, truth, start in views(side, flaws, seed)]


def angle_errors(results: list[tuple[np.ndarray, MarkerFit]]) -> np.ndarray:
    d = np.array([in_plane_angle(f.corners) - in_plane_angle(truth) for truth, f in results])
    return (d + np.pi) % (2 * np.pi) - np.pi


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def corner_z(results: list[tuple[np.ndarray, MarkerFit]]) -> float:
    """RMS over all eight coordinates of the error in units of its claimed covariance; 1 where the covariance is true."""
    errors = [((f.corners - truth).ravel(), f.covariance) for truth, f in results]
    return float(np.sqrt(np.mean([x @ np.linalg.solve(c, x) / 8 for x, c in errors])))


# 3 standard deviations of an RMS over n values of unit variance are 3 / sqrt(2 n)
ANGLE_MARGIN = 3 / np.sqrt(2 * COUNT)
CORNER_MARGIN = 3 / np.sqrt(2 * COUNT * 8)


@pytest.mark.parametrize("side", [30, 60])
def test_ideal_pictures_give_the_bound_and_a_true_covariance(side: int) -> None:
    results = fits(side, CLEAN)
    _, truth, start = views(side, CLEAN, 1, 1)[0]
    limit = bound(start.cells, truth, int(1.9 * side + 24), CLEAN)
    assert not any(f.fell_back for _, f in results)
    assert rms(angle_errors(results)) < 1.3 * limit * (1 + ANGLE_MARGIN)
    assert 0.9 - CORNER_MARGIN < corner_z(results) < 1.1 + CORNER_MARGIN


@pytest.mark.parametrize(
    "flaws",
    [
        replace(CLEAN, slope=(0.4, 0.25)),
        replace(CLEAN, jpeg=80),
        replace(CLEAN, motion=(5.0, 3.3)),
        replace(CLEAN, cable=6.0),
        replace(CLEAN, hidden=0.25),
    ],
    ids=["slope", "jpeg", "motion", "cable", "hidden"],
)
def test_flawed_pictures_stay_within_their_sigma(flaws: Flaws) -> None:
    results = fits(60, flaws)
    assert not any(f.fell_back for _, f in results)
    assert 0.8 - CORNER_MARGIN < corner_z(results) < 1.25 + CORNER_MARGIN
    assert all(f.blurred == (flaws.motion != (0.0, 0.0)) for _, f in results)
    if flaws.hidden:
        assert all(f.hidden > 0.15 for _, f in results)
        # no marker may be far off: the sides that are left hold it
        assert np.degrees(np.abs(angle_errors(results)).max()) < 0.1


def test_without_planes_of_light_a_slope_costs_accuracy(monkeypatch: pytest.MonkeyPatch) -> None:
    flaws = replace(CLEAN, slope=(0.8, -0.5), noise=2.0)
    with_planes = corner_errors(fits(60, flaws))
    monkeypatch.setattr(vision.markers.photometric_solver, "SLOPE_SD", 1e-6)
    assert corner_errors(fits(60, flaws)) > 1.5 * with_planes


def test_without_the_motion_in_the_template_a_blurred_marker_is_worse() -> None:
    made = views(60, replace(CLEAN, motion=(5.0, 3.3)), 1)
    still = [(truth, fit_markers(g, [replace(start, motion=REST)], OPTICS)[0]) for g, truth, start in made]
    known = [(truth, fit_markers(g, [start], OPTICS)[0]) for g, truth, start in made]
    assert corner_errors(still) > 1.5 * corner_errors(known)


def corner_errors(results: list[tuple[np.ndarray, MarkerFit]]) -> float:
    return rms(np.array([f.corners - truth for truth, f in results]))


def test_ink_and_blur_are_found() -> None:
    wide = Optics()
    results = [f for _, f in fits(60, replace(CLEAN, bleed=0.25, psf=0.9), optics=wide)]
    assert np.median([f.bleed for f in results]) == pytest.approx(0.25, abs=0.03)
    assert np.median([f.sigma for f in results]) == pytest.approx(0.9, abs=0.05)


def test_several_markers_of_a_frame_are_fitted_as_each_alone() -> None:
    made = views(60, CLEAN, 1, 3)
    grey = np.hstack([g for g, _, _ in made])
    size = made[0][0].shape[1]
    starts = [replace(s, corners=s.corners + np.array([k * size, 0])) for k, (_, _, s) in enumerate(made)]
    for k, fit in enumerate(fit_markers(grey, starts, OPTICS)):
        alone = fit_markers(made[k][0], [made[k][2]], OPTICS)[0]
        assert np.abs(fit.corners - [k * size, 0] - alone.corners).max() < 0.3 * np.sqrt(alone.covariance.max())
    assert fit_markers(grey, [], OPTICS) == []


@pytest.mark.parametrize("shift", [12.0, 500.0, np.nan])
def test_a_start_that_is_no_start_gives_no_measurement(shift: float) -> None:
    grey, truth, start = views(60, CLEAN, 1, 1)[0]
    fit = fit_markers(grey, [replace(start, corners=truth + shift)], OPTICS)[0]
    assert fit.fell_back
    assert np.isnan(fit.corners).all()
    assert np.isnan(fit.covariance).all()


def test_an_empty_wall_is_flagged() -> None:
    _, _, start = views(60, CLEAN, 1, 1)[0]
    fit = fit_markers(np.full((138, 138), 128, dtype=np.uint8), [start], OPTICS)[0]
    assert fit.fell_back
    assert np.isnan(fit.corners).all()


@pytest.mark.parametrize("side", [30, 60, 120])
def test_the_templates_bound_is_that_of_rendered_pictures(side: int) -> None:
    _, truth, start = views(side, CLEAN, 3, 1)[0]
    rendered = bound(start.cells, truth, int(1.9 * side + 24), CLEAN)
    ours = angle_bound(truth, start.cells, REST, OPTICS, CLEAN.white - CLEAN.black, CLEAN.noise)
    # pixels away from edges are left out, so a little above
    assert rendered == pytest.approx(ours, rel=0.03)


def test_claimed_covariance_is_near_the_bound() -> None:
    _, truth, start = views(60, CLEAN, 1, 1)[0]
    least = corner_bound(truth, start.cells, REST, OPTICS, CLEAN.white - CLEAN.black, CLEAN.noise)
    claimed = np.mean([np.trace(f.covariance) for _, f in fits(60, CLEAN)])
    assert 1.0 < claimed / np.trace(least) < 1.3**2


def test_slopes_of_the_motion_are_those_of_differences() -> None:
    H = homography(square(60, 0.4, np.array([50.0, 40.0]), (0.05, -0.03))[None])
    h = 1e-6
    for j, one in enumerate(h * np.eye(8)):
        by_hand = (move_corners(H, one[None]) - move_corners(H, -one[None]))[0].ravel() / (2 * h)
        np.testing.assert_allclose(corner_slopes(H)[0][:, j], by_hand, atol=1e-6)


def test_slopes_of_the_angle_are_those_of_differences() -> None:
    corners = 30 * CORNERS @ np.array([[0.9, 0.3], [-0.4, 1.1]])
    h = 1e-6
    for j, one in enumerate(h * np.eye(8)):
        step = one.reshape(4, 2)
        by_hand = (in_plane_angle(corners + step) - in_plane_angle(corners - step)) / (2 * h)
        assert angle_slopes(corners)[j] == pytest.approx(float(by_hand), abs=1e-7)
