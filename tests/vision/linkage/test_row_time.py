"""A rolling shutter that nobody spoke of is found by the motion, on corners that another geometry placed row by row."""

from collections.abc import Callable

import numpy as np
import pytest

from mechanism.description import Neck, read_neck
from tests.paths import NECK_FILE
from tests.vision.linkage.test_linkage_fit import camera
from tests.vision.scene import NOISE_PX, rolled
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.row_time import RowTime
from vision.shutter import Shutter, at_middle_row

NECK = read_neck(NECK_FILE)
TIME = np.arange(300) / 30
HEIGHT = camera().height


def swinging(seed: int) -> Callable[[np.ndarray], np.ndarray]:
    """Sums of three sines in every joint, 0.2 to 1 Hz."""
    rng = np.random.default_rng(seed)
    size, hertz, phase = (rng.uniform(low, high, (3, 3)) for low, high in ((0.1, 0.3), (0.2, 1.0), (0.0, 6.0)))

    def alpha_at(t: np.ndarray) -> np.ndarray:
        return np.sum(size * np.sin(2 * np.pi * np.multiply.outer(t, hertz) + phase), axis=1)

    return alpha_at


def seen(row_s: float, seed: int) -> np.ndarray:
    """Corners with noise; from the second seed on every marker is in a plane of its own."""
    rng = np.random.default_rng([seed, 1])
    assert NECK.markers is not None
    count = len(NECK.markers.on_bars)
    depth = rng.uniform(-0.008, 0.008, count) if seed else None
    return rolled(NECK, TIME, swinging(seed), row_s, depth) + NOISE_PX * rng.normal(size=(len(TIME), count, 4, 2))


def fitted(corners: np.ndarray, row_s: float = 0.0, neck: Neck = NECK) -> tuple[LinkageFit, RowTime]:
    mended = at_middle_row(TIME, corners, HEIGHT, Shutter(row_s=row_s))
    fit = fit_linkage(neck, camera(), mended, "test", time=TIME)
    assert fit.row_time is not None
    return fit, fit.row_time


@pytest.mark.parametrize(("row_s", "seed"), [(15e-6, 0), (15e-6, 1), (-25e-6, 2), (40e-6, 3)])
def test_it_is_found_and_the_angles_are_right_then(row_s: float, seed: int) -> None:
    """The first step leads to within 2 %; then what is left is chance, and the angles are as good as their sigma."""
    corners, truth = seen(row_s, seed), swinging(seed)(TIME)
    wrong, first = fitted(corners)
    assert first.is_sure
    assert first.seconds == pytest.approx(row_s, rel=0.02)
    fit, left = fitted(corners, first.seconds)
    assert not left.is_sure
    assert abs(first.seconds + left.seconds - row_s) < 4 * left.sigma
    inside = slice(1, -1)  # the first and the last velocity are one-sided
    before, after = (np.sqrt(np.mean((f.alpha - truth)[inside] ** 2)) for f in (wrong, fit))
    sigma = np.sqrt(np.mean(np.diagonal(fit.covariance, axis1=1, axis2=2)))
    assert after < 1.5 * sigma
    assert before > 5 * after


def dragged(neck: Neck, seed: int) -> np.ndarray:
    """Corners by a global shutter, each of which a codec drags by a time of its own, 0.3 ms (one standard deviation)."""
    rng = np.random.default_rng([seed, 2])
    count = 4 * (neck.N + 1)
    of_corner = [
        rolled(neck, TIME + late, lambda t: swinging(seed)(t)[..., : neck.N], 0.0)
        for late in rng.normal(0, 3e-4, count)
    ]
    out = np.stack([of_corner[k][:, k // 4, k % 4] for k in range(count)], axis=1).reshape(len(TIME), -1, 4, 2)
    return out + NOISE_PX * rng.normal(size=out.shape)


@pytest.mark.parametrize("mechanisms", [1, 3])
def test_what_a_codec_drags_is_in_sigma_and_is_no_rolling_shutter(mechanisms: int) -> None:
    """Ten recordings: spread of error over sigma between 0.5 and 1.6 (99.8 % of chi-squares of ten), none called sure."""
    neck = first_mechanisms(mechanisms)
    z = []
    for seed in range(10):
        _, found = fitted(dragged(neck, seed), neck=neck)
        assert not found.is_sure
        z.append(found.seconds / found.sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.6


def first_mechanisms(count: int) -> Neck:
    """The lowest mechanisms of the sample's arm with their markers."""
    assert NECK.markers is not None
    on_bars = tuple(m for m in NECK.markers.on_bars if m.bar in range(count + 1))
    markers = NECK.markers.model_copy(update={"on_bars": on_bars})
    return NECK.model_copy(update={"mechanisms": NECK.mechanisms[:count], "markers": markers})


def test_it_is_found_beside_frames_that_miss_a_marker() -> None:
    """Every fourth frame lacks one: what is not seen has no place that anything could move from."""
    corners = seen(15e-6, 1)
    corners[2::4, 1] = np.nan
    _, found = fitted(corners)
    assert found.seconds == pytest.approx(15e-6, rel=0.05)


def test_a_wrong_drawing_is_no_rolling_shutter() -> None:
    """Bars 3 % longer than drawn: residuals come and go with the pose, whichever way the arm moves."""
    mechanisms = [m.model_copy(update={"L": 0.97 * m.L}) for m in NECK.mechanisms]
    for seed in range(4):
        _, found = fitted(seen(0.0, seed), neck=NECK.model_copy(update={"mechanisms": mechanisms}))
        assert not found.is_sure


def test_an_arm_at_rest_says_nothing() -> None:
    still = np.repeat(seen(0.0, 0)[:1], len(TIME), axis=0)
    fit = fit_linkage(NECK, camera(), still, "test", time=TIME)
    assert fit.row_time is None
