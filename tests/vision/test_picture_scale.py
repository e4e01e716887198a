"""A focus that breathes is told by what stands still, and a shaking tripod, a shadow or a knock is none."""

import numpy as np
import pytest

from tests.vision.linkage.test_linkage_fit import NECK, camera, motion
from tests.vision.scene import corners
from vision.picture_scale import at_usual_scale, beating_scale, scale_warning

FRAMES = 300
TIME = np.arange(FRAMES) / 30
AXIS = camera().K[:2, 2]
WAVE = np.sin(2 * np.pi * 0.3 * TIME)


def seen(scale: np.ndarray | float = 0.0, shift: np.ndarray | float = 0.0) -> np.ndarray:
    """Corners with .02 px noise, about the optical axis larger by `scale` (F,), moved along x by `shift` (F,), px."""
    places = corners(NECK, motion(FRAMES), 5, 0.02)
    places = AXIS + (places - AXIS) * (1 + np.broadcast_to(scale, FRAMES)[:, None, None, None])
    places[..., 0] += np.broadcast_to(shift, FRAMES)[:, None, None]
    return places


@pytest.mark.parametrize("size", [0.001, 0.002, 0.01])
def test_a_focus_that_breathes_is_found_and_taken_out(size: float) -> None:
    still = seen()
    found = beating_scale(TIME, seen(size * WAVE), camera())
    assert found is not None
    np.testing.assert_allclose(found - found.mean(), size * (WAVE - WAVE.mean()), atol=2e-4)
    assert f"{100 * size / np.sqrt(2):.2f} % rms" in scale_warning(found)[0]
    left = at_usual_scale(seen(size * WAVE), found, camera()) - still
    assert np.sqrt(np.mean((left - left.mean(axis=0)) ** 2)) < 0.06


def test_what_is_no_breathing_is_none() -> None:
    """A still camera; a tripod that shakes by a third of a pixel; a scale that changes once, or grows slowly."""
    for scale, shift in ((0.0, 0.0), (0.0, 0.3 * WAVE), (0.002 * (TIME > 4), 0.0), (0.002 * TIME / TIME[-1], 0.0)):
        assert beating_scale(TIME, seen(scale, shift), camera()) is None


def test_a_marker_that_only_seems_to_grow_is_no_breathing() -> None:
    """Its corners go out and in, as where a shadow passes, and its middle stays."""
    places = seen()
    middle = places[:, :1].mean(axis=2, keepdims=True)
    places[:, :1] = middle + (places[:, :1] - middle) * (1 + 0.003 * WAVE)[:, None, None, None]
    assert beating_scale(TIME, places, camera()) is None


def test_without_a_marker_that_stands_nothing_is_said() -> None:
    places = seen(0.002 * WAVE)
    places[:, 0] = np.nan
    assert beating_scale(TIME, places, camera()) is None
    assert scale_warning(None) == []
