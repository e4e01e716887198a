"""Recovery, honest error bars, and a refusal wherever the views cannot tell."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calibration.board import Chessboard
from calibration.corners import BoardView
from calibration.estimation import calibrate
from calibration.summary import as_json
from calibration.views import LeftOut, Observations
from tests.calibration.truth import CAMERA, SIZE, synthetic_views
from xneck.errors import Refused

CORNERS = Chessboard(kind="chessboard", columns=8, rows=6, square=0.025).corners


def seen(views: list[BoardView], left_out: tuple[LeftOut, ...] = ()) -> Observations:
    return Observations(tuple(views), left_out, SIZE)


def views(seed: int = 0, **how) -> list[BoardView]:
    return synthetic_views(np.random.default_rng(seed), CORNERS, **how)


def spread(**how) -> tuple[float, float]:
    """Root mean square of error over sigma over 10 seeds, of what is reported and of least squares alone."""
    reported, plain = [], []
    for seed in range(10):
        result = calibrate(seen(views(seed, **how)))
        error = (result.camera.parameters - CAMERA)[:4]
        assert result.camera.covariance is not None
        reported.append(error / np.sqrt(np.diag(result.camera.covariance))[:4])
        plain.append(error / result.sigma_least_squares[:4])
    return float(np.sqrt(np.mean(np.square(reported)))), float(np.sqrt(np.mean(np.square(plain))))


def test_error_bars_hold_for_independent_noise():
    reported, plain = spread()
    assert 0.5 < reported < 1.3
    assert 0.6 < plain < 1.5


def test_error_bars_hold_where_errors_are_common_to_a_view():
    reported, plain = spread(bow_m=0.0005)
    assert reported < 1.6
    assert plain > 1.5 * reported, "least squares alone would be far too sure"


def test_result_is_complete():
    left_out = (LeftOut("empty.png", "the board was not found"),)
    result = calibrate(seen(views(1), left_out))
    assert result.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.1)
    assert result.rms_px < result.held_out_rms_px < 1.15 * result.rms_px
    assert result.free[-1] == "p2", "k3 stays zero unless the views want it"
    assert result.corners == 15 * 48
    assert np.degrees(result.tilt) > 40
    document = as_json(result)
    json.dumps(document, allow_nan=False)
    assert [p["name"] for p in document["parameters"]] == ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"]
    assert document["parameters"][0]["unit"] == "px"
    assert document["parameters"][0]["identified"] is True
    assert document["parameters"][8] == {
        "name": "k3",
        "index": None,
        "value": 0.0,
        "unit": "1",
        "sigma": None,
        "relative_sigma_percent": None,
        "identified": False,
    }
    assert document["pictures"][0] == {
        "file": "empty.png",
        "used": False,
        "why": "the board was not found",
        "rms_px": None,
        "held_out_rms_px": None,
    }
    assert result.camera.info["pictures"][0]["why"] == "the board was not found"
    assert result.camera.covariance is not None
    assert np.linalg.eigvalsh(result.camera.covariance).min() > -1e-9


def test_k3_is_taken_where_the_lens_has_it():
    wild = CAMERA + np.array([0, 0, 0, 0, 0, 0, 0, 0, -0.9])
    result = calibrate(seen(views(2, parameters=wild)))
    assert "k3" in result.free
    assert abs(result.camera.parameters[8] + 0.9) < 4 * np.sqrt(result.camera.covariance[8, 8])  # type: ignore[index]


def test_a_view_that_disagrees_is_named():
    good = views(3)
    rng = np.random.default_rng(0)
    # corners dragged towards their neighbours, as a refinement window that is too large does
    bad = replace(good[4], image_points=good[4].image_points + rng.normal(scale=0.9, size=(48, 2)))
    result = calibrate(seen([*good[:4], bad, *good[5:]]))
    (out,) = [picture for picture in result.pictures if not picture.used]
    assert out.name == "view 04"
    assert "disagrees: 1." in out.why
    assert "agree to 0.13 px" in out.why


def test_repeated_views_do_not_count():
    few = views(4, count=8)
    rng = np.random.default_rng(0)
    again = [
        replace(view, name=f"again {i}", image_points=view.image_points + rng.normal(scale=0.1, size=(48, 2)))
        for i, view in enumerate(few)
    ]
    once, twice = calibrate(seen(few)), calibrate(seen(few + again))
    assert len(twice.views) == 8
    np.testing.assert_allclose(twice.sigma_jackknife, once.sigma_jackknife, rtol=1e-6)
    np.testing.assert_allclose(twice.sigma_least_squares, once.sigma_least_squares, rtol=1e-6)
    assert next(p.why for p in twice.pictures if not p.used) == "the board stands as in view 00"


def test_uncovered_parts_of_the_picture_are_named():
    left = [view for view in views(5, count=60) if view.image_points[:, 0].max() < 2 * SIZE[0] / 3]
    (note,) = [note for note in calibrate(seen(left)).notes if "no corners" in note]
    assert "upper right, middle right, lower right" in note
    assert "left" not in note.replace("left out", "")


class TestRefuses:
    def test_few_views(self):
        out = (LeftOut("x.png", "the board was not found"),)
        with pytest.raises(
            Refused, match=r"5 distinct views of the board \(left out: x.png: the board was not found\)"
        ):
            calibrate(seen(views(count=5), out))

    def test_views_that_only_repeat(self):
        one = views(count=5)
        copies = [replace(view, name=f"{view.name} again") for view in one]
        with pytest.raises(Refused, match=r"5 distinct views .*stands as in view 00.* and 2 more\); take 6 or more"):
            calibrate(seen(one + copies))

    @pytest.mark.parametrize("seed", range(4))
    def test_boards_that_all_face_the_camera(self, seed: int):
        with pytest.raises(Refused, match=r"tilted alike|focal length is known to"):
            calibrate(seen(views(seed, tilt_deg=1.0)))

    def test_boards_that_all_face_the_camera_without_noise(self):
        with pytest.raises(Refused, match=r"tilted alike|focal length is known to"):
            calibrate(seen(views(tilt_deg=0.0, noise_px=0.0)))

    def test_poorly_known_focal_length(self):
        with pytest.raises(Refused, match=r"focal length is known to .* % only"):
            calibrate(seen(views(count=6, tilt_deg=7.0, noise_px=0.5)))

    def test_corners_that_are_not_finite(self):
        broken = views()
        points = broken[7].image_points.copy()
        points[3, 1] = np.nan
        broken[7] = replace(broken[7], image_points=points)
        with pytest.raises(Refused, match="view 07: corner coordinates that are not finite"):
            calibrate(seen(broken))

    def test_corners_that_no_camera_explains(self):
        rng = np.random.default_rng(0)
        noisy = [replace(v, image_points=v.image_points + rng.normal(scale=3.0, size=(48, 2))) for v in views()]
        with pytest.raises(Refused, match=r"no camera .* explains the corners: 4\.\d\d px rms"):
            calibrate(seen(noisy))

    def test_a_fisheye(self):
        # pixels proportional to the angle, boards up to 80 degrees off the axis, tilted by up to 40 against the ray
        rng = np.random.default_rng(0)
        wide, away = [], np.array([-0.1, -0.07, 0.3])
        for i in range(20):
            ray = Rotation.from_rotvec([*rng.uniform(-0.85, 0.85, 2), 0.0])
            seen_points = ray.apply(Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3)).apply(CORNERS) + away)
            across = np.linalg.norm(seen_points[:, :2], axis=1)
            angle = np.arctan2(across, seen_points[:, 2])
            pixels = [320, 240] + 220 * (angle / across)[:, None] * seen_points[:, :2]
            wide.append(BoardView(f"{i}", pixels, CORNERS, np.arange(48)))
        with pytest.raises(Refused, match="fisheye"):
            calibrate(seen(wide))

    def test_a_line_of_corners(self):
        line = [
            replace(v, image_points=v.image_points[:8], object_points=v.object_points[:8], corner_ids=v.corner_ids[:8])
            for v in views()
        ]
        with pytest.raises(Refused, match="pictures: "):
            calibrate(seen(line))
