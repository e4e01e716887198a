"""The fitted corner: its derivatives, and its place in pictures integrated from exact edges."""

import cv2
import numpy as np

from calibration import saddle
from calibration.saddle import fit_saddles


def crossing(at: np.ndarray, turn: float, shear: float, blur: float, fine: int = 16) -> np.ndarray:
    """Four squares that meet at `at` px, area-sampled, then blurred; 41 x 41 px, black 30 and white 220."""
    grid = (np.arange(41 * fine) + 0.5) / fine - 0.5
    x, y = np.meshgrid(grid - at[0], grid - at[1])
    first = np.cos(turn) * x + np.sin(turn) * y
    second = np.cos(turn + np.pi / 2 + shear) * x + np.sin(turn + np.pi / 2 + shear) * y
    light = np.where(first * second > 0, 220.0, 30.0)
    return cv2.GaussianBlur(light.reshape(41, fine, 41, fine).mean(axis=(1, 3)), (0, 0), blur)


def test_derivatives():
    rng = np.random.default_rng(0)
    state = np.column_stack([rng.normal(0, 0.4, (5, 2)), rng.uniform(-3, 3, (5, 2)), rng.uniform(0.8, 2.5, (5, 2))])
    du = rng.uniform(-6, 6, (40, 2))
    _, by = saddle._saddle(state, du)
    for column in range(6):
        h = np.zeros(6)
        h[column] = 1e-6
        slope = (saddle._saddle(state + h, du)[0] - saddle._saddle(state - h, du)[0]) / 2e-6
        np.testing.assert_allclose(by[..., column], slope, atol=1e-8)


def test_place_from_two_pixels_away_and_honest_sigma():
    rng = np.random.default_rng(1)
    z = []
    for _ in range(60):
        at = 20 + rng.uniform(-0.5, 0.5, 2)
        turn, shear = rng.uniform(0, np.pi), rng.uniform(-0.4, 0.4)
        grey = crossing(at, turn, shear, rng.uniform(0.6, 1.5)) + rng.normal(0, 3.0, (41, 41))
        sides = 40 * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        begin = at + rng.uniform(-1.4, 1.4, 2)
        (fitted,) = [fit_saddles(np.round(grey).astype(np.uint8), begin[None], sides[None], 0.45, 0.2)]
        assert np.abs(fitted.points[0] - at).max() < 0.15
        z.append((fitted.points[0] - at) / fitted.sigma[0])
    # 120 numbers: their root mean square is known to 6.5 %, and the model is not quite the pixels' integral
    assert 0.75 < np.sqrt(np.mean(np.square(z))) < 1.35


def test_tones_and_ink_do_not_move_it():
    at = np.array([20.3, 19.8])
    light = crossing(at, 0.4, 0.2, 1.0)
    curved = 255 * (light / 255) ** 0.45
    bled = cv2.erode(light, np.ones((3, 3)))
    sides = 40 * np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
    for grey in (light, curved, bled):
        found = fit_saddles(np.round(grey).astype(np.uint8), np.array([[20.0, 20.0]]), sides[None], 0.45, 0.2)
        np.testing.assert_allclose(found.points[0], at, atol=0.02)
