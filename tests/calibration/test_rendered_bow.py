"""A board that bows by 0.5 mm in every picture, from the pictures on."""

from pathlib import Path

import numpy as np

from calibration.board import Charuco
from calibration.bundle_adjustment import fit_bundle, initial_estimate
from calibration.estimation import calibrate
from calibration.observations import observe_board
from calibration.sheets import board_sheet
from calibration.stacked_views import stack_views
from tests.calibration.truth import CAMERA, SIZE, picture, poses, raster, svg_blacks

BOARD = Charuco(kind="charuco", columns=9, rows=6, square=0.025, marker=0.0175, dictionary="aruco_5x5_100")


def test_bow_and_focal_length_are_recovered_from_pictures(tmp_path: Path):
    board_sheet(BOARD, tmp_path / "board.svg")
    size, shapes = svg_blacks(tmp_path / "board.svg")
    texture = raster(size, shapes, 8)
    x, y = np.concatenate([loop for shape in shapes for loop in shape]).min(axis=0)
    half = np.ptp(BOARD.corners[:, 0]) / 2
    bow = (0.0005, float(np.mean(BOARD.corners[:, 0])), 0.0, float(half))
    rng = np.random.default_rng(5)
    shots = [
        picture(texture, 8, (float(x), float(y)), R, t, rng, f"{i:02d}.png", bow)
        for i, (R, t) in enumerate(poses(rng, 20, BOARD.size))
    ]
    observations = observe_board(iter(shots), BOARD)
    result = calibrate(observations)
    assert result.board.model.name != "rigid"
    np.testing.assert_allclose(result.camera.parameters[:2], CAMERA[:2], atol=1.0)
    np.testing.assert_allclose(result.board.bow, [0.0005, 0.0], atol=5e-5)
    at = stack_views(observations.views)
    flat = fit_bundle(at, initial_estimate(at, SIZE))
    assert np.all(np.abs(flat.parameters - CAMERA)[:2] > 5 * np.sqrt(np.diag(flat.covariance))[:2])
