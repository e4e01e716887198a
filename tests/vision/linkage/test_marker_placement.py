"""Markers placed wrongly in neck.yaml are found again from the motion of the linkage, as far as it shows them."""

from functools import cache

import numpy as np

from mechanism.description import Neck
from mechanism.printed_markers import BarMarker
from tests.vision.linkage.test_linkage_fit import camera, with_markers
from tests.vision.scene import corners
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import LinkageOptions, PlacementPrior

BARS = [{"bar": i} for i in range(4)]
DIAGONALS = [{"diagonal": f"A{i}"} for i in (1, 2, 3)]


def wrong(neck: Neck, seed: int) -> Neck:
    """As someone might have measured it: every marker up to 2 mm and 2 deg from where it sits."""
    assert neck.markers is not None
    rng = np.random.default_rng([77, seed])

    def off(m: BarMarker) -> BarMarker:
        x, y = (float(v + rng.uniform(-0.002, 0.002)) for v in m.at)
        return m.model_copy(update={"at": (x, y), "angle": float(m.angle + np.radians(rng.uniform(-2, 2)))})

    on_bars = tuple(off(m) for m in neck.markers.on_bars)
    return neck.model_copy(update={"markers": neck.markers.model_copy(update={"on_bars": on_bars})})


def motion(frames: int, degrees: float, seed: int) -> np.ndarray:
    t = np.arange(frames) / 30
    phase = np.random.default_rng(seed).uniform(0, 6, 3)
    return np.radians(degrees) * np.sin(2 * np.pi * np.outer(t, [0.31, 0.47, 0.73]) + phase)


def placed(neck: Neck) -> np.ndarray:
    assert neck.markers is not None
    return np.array([[*m.at, m.angle] for m in neck.markers.on_bars]).ravel()


@cache
def recording(seed: int, frames: int, degrees: float, diagonals: bool) -> tuple[np.ndarray, LinkageFit, Neck]:
    """alpha, its fit from wrong markers, and the arm as it is."""
    neck = with_markers(BARS + DIAGONALS * diagonals)
    alpha = motion(frames, degrees, seed)
    seen = corners(neck, alpha, seed)
    return alpha, fit_linkage(wrong(neck, seed), camera(), seen, "test", options=LinkageOptions(PlacementPrior())), neck


def test_with_a_marker_on_a_diagonal_of_each_mechanism_the_bias_of_alpha_goes() -> None:
    """60 s, +-30 deg, 0.05 px: the bound of Cramér and Rao is 0.0063 deg, 0.03 deg is 4.7 times that; before it is degrees."""
    for seed in range(3):
        alpha, fit, neck = recording(seed, 1800, 30.0, True)
        believed = fit_linkage(wrong(neck, seed), camera(), corners(neck, alpha, seed)[::20], "test")
        assert np.max(np.abs(np.mean(believed.alpha - alpha[::20], axis=0))) > np.radians(0.5)
        assert np.max(np.abs(np.mean(fit.alpha - alpha, axis=0))) < np.radians(0.03)
        assert fit.placement is not None
        assert all(n.determined for n in fit.placement.numbers)


def test_with_one_marker_a_bar_the_zero_of_alpha_is_known_as_well_as_sigma_says() -> None:
    """The same motion without diagonals leaves 0.09 deg at 0.05 px, 0.022 deg at the 0.0114 px of a photometric refinement."""
    neck = with_markers(BARS)
    alpha = motion(1800, 30.0, 5)
    fit = fit_linkage(
        wrong(neck, 5),
        camera(),
        corners(neck, alpha, 5, noise=0.0114),
        "test",
        options=LinkageOptions(PlacementPrior()),
    )
    assert fit.noise is not None
    sigma = np.sqrt(np.diagonal(fit.covariance - fit.noise, axis1=1, axis2=2).mean(axis=0))
    assert np.all(sigma < np.radians(0.026))
    assert np.all(np.abs(np.mean(fit.alpha - alpha, axis=0)) < 3.5 * sigma)


def test_error_over_sigma_has_spread_one() -> None:
    """6 recordings of 30 s, 12 numbers each: the spread scatters by 0.08 around one; so do the angles' common errors (0.17)."""
    number, angle = [], []
    for seed in range(6):
        alpha, fit, neck = recording(seed, 900, 40.0, False)
        assert fit.placement is not None
        assert fit.noise is not None
        error = np.array([n.value for n in fit.placement.numbers]) - placed(neck)
        number.append(error @ np.linalg.solve(fit.placement.covariance, error) / len(error))
        common = np.mean(fit.covariance - fit.noise, axis=0) + np.mean(fit.noise, axis=0) / len(alpha)
        bias = np.mean(fit.alpha - alpha, axis=0)
        angle.append(np.mean(bias**2 / np.diag(common)))
    assert 0.8 < np.sqrt(np.mean(number)) < 1.2
    assert 0.6 < np.sqrt(np.mean(angle)) < 1.4


def test_small_motion_determines_no_angle_and_says_so() -> None:
    """Negative control, +-2 deg: the angles' words are no, their values stay within the prior, alpha confesses degrees."""
    alpha, fit, _ = recording(1, 900, 2.0, False)
    assert fit.placement is not None
    angles = [n for n in fit.placement.numbers if n.name == "angle"]
    assert not any(n.determined for n in angles)
    assert all(n.word.startswith("not determined") for n in angles)
    assert all(abs(n.value - n.nominal) < n.prior_sigma and n.sigma < n.prior_sigma for n in angles)
    sigma = np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))
    assert np.all(sigma > np.radians(1.0))
    assert np.all(np.abs(fit.alpha - alpha) < 3 * sigma)
    assert len(fit.notes["placement"]) == 12


def test_an_arm_that_stands_still_keeps_its_description() -> None:
    neck = with_markers(BARS)
    alpha = np.full((100, 3), 0.1)
    found = fit_linkage(
        neck, camera(), corners(neck, alpha, 0), "test", options=LinkageOptions(PlacementPrior())
    ).placement
    assert found is not None
    assert all(abs(n.value - n.nominal) < 0.5 * n.prior_sigma for n in found.numbers)
    assert not any(n.determined for n in found.numbers if n.name != "y")


def test_the_corrected_arm_gives_the_same_angles_without_another_estimate() -> None:
    alpha, fit, neck = recording(0, 1800, 30.0, True)
    assert fit.placement is not None
    again = fit_linkage(fit.placement.neck, camera(), corners(neck, alpha, 0), "test")
    assert np.max(np.abs(again.alpha - fit.alpha)) < np.radians(0.01)


def test_lengths_too_if_asked_for() -> None:
    """L of one mechanism 0.5 mm off, free within 1 mm: back within four of its standard deviations, and those are small."""
    true = with_markers(BARS + DIAGONALS)
    first = true.mechanisms[0].model_copy(update={"L": true.mechanisms[0].L + 0.0005})
    believed = wrong(true.model_copy(update={"mechanisms": (first, *true.mechanisms[1:])}), 3)
    options = LinkageOptions(PlacementPrior(length_sigma=0.001))
    found = fit_linkage(believed, camera(), corners(true, motion(900, 30.0, 3), 3), "test", options=options).placement
    assert found is not None
    lengths = {(n.name, n.where): n for n in found.numbers if n.name in "Lb"}
    L = lengths["L", "mechanism 1"]
    assert L.determined
    assert abs(L.value - true.mechanisms[0].L) < 4 * L.sigma
    assert L.value == found.neck.mechanisms[0].L
    assert len(lengths) == 6
