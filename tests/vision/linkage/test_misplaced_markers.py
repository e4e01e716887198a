"""Markers that were stuck on beside their places: noticed, and held by sigma, on corners that another geometry placed."""

import numpy as np
import pytest

from mechanism.description import Neck
from mechanism.printed_markers import BarMarker
from tests.vision.linkage.test_linkage_fit import NECK, camera, motion
from tests.vision.scene import corners
from vision.linkage.linkage_fit import LinkageFit, fit_linkage
from vision.linkage.shared_fit import LinkageOptions
from vision.misplaced_markers import misplacement

FRAMES = 240
SEEDS = range(6)


def as_drawn(neck: Neck, seed: int, by_hand: float) -> Neck:
    """A description of an arm whose markers sit beside it by so many times 0.5 mm and 0.3 deg (one standard deviation)."""
    assert neck.markers is not None
    rng = np.random.default_rng([seed, 7])

    def off(m: BarMarker) -> BarMarker:
        x, y, angle = rng.normal(0, by_hand * np.array([5e-4, 5e-4, np.radians(0.3)]))
        return m.model_copy(update={"at": (m.at[0] + x, m.at[1] + y), "angle": m.angle + angle})

    on_bars = tuple(off(m) for m in neck.markers.on_bars)
    return neck.model_copy(update={"markers": neck.markers.model_copy(update={"on_bars": on_bars})})


def with_other_lengths(neck: Neck, seed: int, share: float) -> Neck:
    """A description of an arm whose bars differ from it by this share (one standard deviation)."""
    off = np.random.default_rng([seed, 8]).normal(0, share, (neck.N, 2))
    bars = tuple(
        m.model_copy(update={"L": m.L * (1 + L), "b": m.b * (1 + b)})
        for m, (L, b) in zip(neck.mechanisms, off, strict=True)
    )
    return neck.model_copy(update={"mechanisms": bars})


def fits(described: Neck, seed: int) -> tuple[LinkageFit, LinkageFit | None, str]:
    """With markers believed, and as they are fitted where they are in doubt, with what is said then."""
    seen = corners(NECK, motion(FRAMES), seed)
    believed = fit_linkage(described, camera(), seen, "test")
    doubt = misplacement(described, camera(), seen, None, "test", believed, LinkageOptions())
    if doubt is None:
        return believed, None, ""
    prior, said = doubt
    return believed, fit_linkage(described, camera(), seen, "test", options=LinkageOptions(prior)), said


def zeros(fit: LinkageFit) -> np.ndarray:
    """Mean error of each joint over the standard deviation of what all frames share, (N,)."""
    assert fit.noise is not None
    common = np.mean(fit.covariance - fit.noise, axis=0)
    return np.mean(fit.alpha - motion(FRAMES), axis=0) / np.sqrt(np.diag(common))


@pytest.mark.parametrize("by_hand", [0.3, 1.0])
def test_markers_beside_their_places_are_noticed_and_sigma_holds_it(by_hand: float) -> None:
    """Six arms; believed, zeros are off by many sigmas. Bounds are those of a chi-square of six: joints of an arm go together."""
    before, after = [], []
    for seed in SEEDS:
        believed, fitted, said = fits(as_drawn(NECK, seed, by_hand), seed)
        assert fitted is not None
        assert "the markers do not sit as neck.yaml says" in said
        before.append(zeros(believed))
        after.append(zeros(fitted))
    assert np.sqrt(np.mean(np.square(before))) > 4
    assert 0.25 < np.sqrt(np.mean(np.square(after))) < 1.9


def test_bars_of_other_lengths_are_no_certainty_either() -> None:
    """By 0.5 %, two and a half times what a workshop keeps; bounds as before."""
    after = []
    for seed in SEEDS:
        _, fitted, _ = fits(with_other_lengths(NECK, seed, 0.005), seed)
        assert fitted is not None
        after.append(zeros(fitted))
    assert np.sqrt(np.mean(np.square(after))) < 1.9


def test_markers_in_their_places_are_believed() -> None:
    """Negative control: nothing is said."""
    for seed in SEEDS:
        assert fits(NECK, seed)[1] is None
