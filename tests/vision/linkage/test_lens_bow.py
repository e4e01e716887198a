"""Edges that the lens bows do not displace the corners that are fitted to them."""

import numpy as np
import pytest

from calibration.dictionaries import marker_cells
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.frame import render_frame
from samples.generator.sensor import vignette
from tests.vision.linkage.test_linkage_fit import NECK, camera
from tests.vision.scene import corners
from vision.linkage.lens_bow import correct_lens_bow
from vision.markers.edge_refinement import refine_by_edges
from vision.markers.photometric import MarkerStart, fit_markers
from vision.markers.template import Optics

ALPHA = np.array([[0.2, 0.15, -0.35], [0.35, -0.3, 0.4], [-0.4, 0.3, 0.2]])


def pictures() -> list[np.ndarray]:
    """The sample's arm at three poses, without noise, motion or compression, the loss of light in the corners taken out."""
    dark = vignette(SAMPLE_CAMERA)
    neck = NECK.model_dump()
    return [
        np.clip(np.rint(render_frame(a, neck, SAMPLE_CAMERA)[..., 1] / dark), 0, 255).astype(np.uint8) for a in ALPHA
    ]


@pytest.mark.parametrize(("by_cells", "limit"), [(True, 0.004), (False, 0.006)])
def test_corners_are_where_they_are_with_a_lens_that_bows(by_cells: bool, limit: float) -> None:
    """Middles of the top marker: without the correction 0.010 px away at least; rounding to grey levels leaves
    0.0025 px where the edges run along the raster, as those of the base marker nearly do."""
    assert NECK.markers is not None
    cells = np.stack([marker_cells(NECK.markers.dictionary, m.id) for m in NECK.markers.on_bars])
    true = corners(NECK, ALPHA)
    found = []
    for picture, at in zip(pictures(), true, strict=True):
        if by_cells:
            starts = [MarkerStart(c, k, np.zeros((4, 2))) for c, k in zip(at, cells, strict=True)]
            found.append([fit.corners for fit in fit_markers(picture, starts, Optics(0.8, 0.0, 0.05, 0.02))])
        else:
            found.append(refine_by_edges(picture, at, cells.shape[1]))
    as_found = np.array(found)
    off = (correct_lens_bow(camera(), as_found, cells if by_cells else None) - true).mean(axis=2)
    before = (as_found - true).mean(axis=2)
    assert np.linalg.norm(before[:, 3], axis=1).max() > 0.010
    assert np.linalg.norm(off, axis=2).max() < limit


def test_a_pinhole_bows_nothing_and_lost_markers_stay_lost() -> None:
    pinhole = camera()
    pinhole.distortion[:] = 0.0
    seen = corners(NECK, ALPHA)
    seen[1, 2] = np.nan
    np.testing.assert_allclose(correct_lens_bow(pinhole, seen, None), seen, atol=1e-9)
    assert np.isnan(correct_lens_bow(camera(), seen, None)[1, 2]).all()
