"""Recovery, honest error bars, and a refusal wherever the views cannot tell."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from calibration import lens
from calibration.board import Chessboard
from calibration.board_shape import SHAPE_MODELS
from calibration.bundle_adjustment import BundleStart, fit_bundle, initial_estimate
from calibration.corner_detection import BoardView
from calibration.cross_check import cross_check
from calibration.estimation import Calibration, calibrate
from calibration.observations import LeftOut, Observations
from calibration.stacked_views import stack_views
from calibration.summary import calibration_json
from tests.calibration.truth import CAMERA, SIZE, bowed, synthetic_views
from xneck_foundation.errors import Refused

CORNERS = Chessboard(kind="chessboard", columns=8, rows=6, square=0.025).corners

CENTRED = np.where(np.isin(np.arange(9), (6, 7)), 0.0, CAMERA)
"""so that any lens model to choose from holds: a jackknife knows nothing of one that does not"""


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


@pytest.fixture(scope="module")
def thirty() -> list[Calibration]:
    """Flat boards; a good part of the noise is alike for neighbouring corners of a view; no tangential distortion."""
    return [calibrate(seen(views(seed, noise_px=0.06, common_px=0.06, parameters=CENTRED))) for seed in range(30)]


def test_error_bars_hold_for_noise_that_neighbours_share(thirty: list[Calibration]):
    errors = np.array([(result.camera.parameters - CENTRED)[:4] for result in thirty])
    reported = [np.sqrt(np.diag(result.camera.covariance))[:4] for result in thirty]  # type: ignore[arg-type]
    z = {
        "reported": errors / reported,
        "jackknife": errors / [result.sigma_jackknife[:4] for result in thirty],
        "least squares": errors / [result.sigma_least_squares[:4] for result in thirty],
    }
    spread = {key: float(np.sqrt(np.mean(np.square(value)))) for key, value in z.items()}
    assert 0.6 < spread["jackknife"] < 1.3
    assert 0.6 < spread["reported"] < 1.3
    assert spread["least squares"] > 1.25 * spread["reported"]


def test_a_flat_board_is_believed_flat(thirty: list[Calibration]):
    assert sum(result.board.model.name == "rigid" for result in thirty) >= 24
    bent = [result for result in thirty if result.board.model.name != "rigid"]
    # where chance bends it after all, by next to nothing
    assert all(np.abs(result.board.bow).max() < 1e-4 for result in bent)


class TestBowedBoard:
    """The same bow of 0.5 mm in all views."""

    BENT = bowed(CORNERS, 0.0005)

    def test_is_recovered(self):
        z = []
        for seed in range(6):
            result = calibrate(seen(views(seed, count=20, noise_px=0.05, shape=self.BENT)))
            assert result.board.model.name.startswith("bowed")
            np.testing.assert_allclose(result.camera.parameters[:2], CAMERA[:2], atol=1.0)
            np.testing.assert_allclose(result.board.bow, [0.0005, 0.0], atol=5e-5)
            z.append((result.board.bow - [0.0005, 0.0]) / result.board_sigma[:2])
            assert any(re.search(r"the board is estimated bowed by 0\.(4[5-9]|5[0-5]) ", note) for note in result.notes)
        assert 0.4 < np.sqrt(np.mean(np.square(z))) < 1.8

    def test_believed_flat_the_focal_length_is_off_by_many_sigmas(self):
        at = stack_views(views(0, count=20, noise_px=0.05, shape=self.BENT))
        rigid = fit_bundle(at, initial_estimate(at, SIZE))
        away = (rigid.parameters - CAMERA)[:2]
        assert np.all(np.abs(away) > 3.0)
        assert np.all(np.abs(away) > 5 * np.sqrt(np.diag(rigid.covariance))[:2])
        assert rigid.rms < 0.2, "and nothing in the error tells"

    def test_free_corners_take_in_a_bow_too(self):
        at = stack_views(views(1, count=20, noise_px=0.05, shape=self.BENT))
        first = fit_bundle(at, initial_estimate(at, SIZE))
        free = fit_bundle(at, BundleStart(first.parameters, first.poses), shape_model=SHAPE_MODELS["free"], noise=0.05)
        np.testing.assert_allclose(free.parameters[:2], CAMERA[:2], atol=1.5)
        np.testing.assert_allclose(free.shape.bow, [0.0005, 0.0], atol=5e-5)

    def test_the_stretch_of_a_printer_is_recovered(self):
        stretched = CORNERS * np.array([1.0, 1.004, 1.0])
        result = calibrate(seen(views(3, count=20, noise_px=0.05, shape=stretched)))
        assert "aspect" in result.board.model.name
        # the belief of 0.3 % pulls, so that a little less than all is found
        assert abs(result.board.values[2] - 0.004) < 4 * result.board_sigma[2]
        assert result.board_sigma[2] < 0.001


def test_free_offsets_hold_nothing_that_poses_or_a_principal_point_do():
    at = stack_views(views(2, count=12, shape=CORNERS + np.random.default_rng(0).normal(scale=1e-4, size=(48, 3))))
    first = fit_bundle(at, initial_estimate(at, SIZE))
    offsets = fit_bundle(
        at, BundleStart(first.parameters, first.poses), shape_model=SHAPE_MODELS["free"], noise=0.1
    ).shape.offsets
    x, y = (CORNERS[:, :2] - CORNERS[:, :2].mean(axis=0)).T
    size = float(np.abs(offsets).sum())
    assert size > 1e-3
    for a, b in (
        (0 * x + 1, 0 * x),
        (0 * x, 0 * x + 1),
        (-y, x),
        (x, y),
        (x, -y),
        (y, x),
        (x * x, x * y),
        (x * y, y * y),
    ):
        assert abs(offsets[:, 0] @ a + offsets[:, 1] @ b) < 1e-9 * size * max(np.abs(a).max(), np.abs(b).max())
    for c in (0 * x + 1, x, y):
        assert abs(offsets[:, 2] @ c) < 1e-9 * size


def test_the_table_of_candidates_is_kept():
    result = calibrate(seen(views(1)))
    assert len(result.candidates) == 15
    (chosen,) = [c for c in result.candidates if c.chosen]
    assert (chosen.lens, chosen.board) == (result.lens, result.board.model.name) == ("k1 k2 p1 p2", "rigid")
    frees = [c.free for c in result.candidates]
    assert frees == sorted(frees)
    assert all(c.held_out_rms_px > c.rms_px for c in result.candidates)
    assert all(c.excess > c.excess_error for c in result.candidates[: result.candidates.index(chosen)])
    nested = {(c.lens, c.board): c.rms_px for c in result.candidates}
    assert nested["k1 k2", "rigid"] >= nested["k1 k2 p1 p2", "rigid"] >= nested["k1 k2 p1 p2 k3", "rigid"] - 1e-6
    document = calibration_json(result)
    assert document["board"]["model"] == "rigid"
    assert document["board"]["bow_x"] == {"value": 0.0, "unit": "m", "sigma": None}
    assert [c["chosen"] for c in document["candidates"]].count(True) == 1
    assert result.camera.info["candidates"][0]["lens"] == "k1 k2"


def test_opencv_agrees_and_a_disagreement_is_said():
    result = calibrate(seen(views(1)))
    assert result.cross_check is not None
    assert np.abs(result.cross_check.differences).max() < 0.5
    assert calibration_json(result)["cross_check"]["differences_sigma"]["k3"] == 0.0
    assert result.cross_check.note(flat=True) is None
    far = cross_check(result.views, SIZE, result.free, result.camera.parameters + 2.0, np.ones(9))
    assert far is not None
    assert "OpenCV's own calibration disagrees: " in (far.note(flat=True) or "")
    assert far.note(flat=False) is None, "OpenCV believes in flat boards only"


def test_a_single_bad_corner_is_named_and_its_view_stays():
    good = views(6)
    points = good[4].image_points.copy()
    points[17] += [4.0, 3.0]
    result = calibrate(seen([*good[:4], replace(good[4], image_points=points), *good[5:]]))
    assert len(result.views) == 15
    (note,) = [note for note in result.notes if "counted for little" in note]
    assert re.match(r"view 04: corner 17 up to (4\.[89]|5\.[0-2]) px off", note), "5 px, and what the noise adds"
    clean = calibrate(seen(good))
    away = (result.camera.parameters - clean.camera.parameters)[:4]
    assert np.all(np.abs(away) < 0.5 * clean.sigma_least_squares[:4])


def test_where_views_disagree_more_than_their_corners_the_note_says_by_how_much():
    result = calibrate(seen(views(7, bow_m=0.0005)))
    (note,) = [note for note in result.notes if "leaving out views is larger" in note]
    ratio = result.sigma_jackknife / np.where(result.sigma_least_squares > 0, result.sigma_least_squares, np.inf)
    worst = int(np.argmax(ratio))
    assert f"{lens.PARAMETER_NAMES[worst]} {ratio[worst]:.1f}" in note


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
    document = calibration_json(result)
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


def fisheye(degrees: float, noise_px: float = 0.1) -> list[BoardView]:
    """Pixels proportional to the angle, `degrees` from corner to corner of the picture, boards up to 72 degrees off the axis."""
    rng = np.random.default_rng(0)
    half = np.radians(degrees / 2)
    wide: list[BoardView] = []
    while len(wide) < 20:
        about = rng.uniform(0, 2 * np.pi)
        off = rng.uniform(0, min(half, 1.25))
        ray = Rotation.from_rotvec(off * np.array([np.cos(about), np.sin(about), 0.0]))
        turn = Rotation.from_rotvec([*rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.4, 0.4)])
        away = np.array([0.0, 0.0, rng.uniform(0.2, 0.4)])
        at = ray.apply(turn.apply(CORNERS - CORNERS.mean(axis=0)) + away)
        across = np.linalg.norm(at[:, :2], axis=1)
        angle = np.arctan2(across, at[:, 2])
        pixels = [320, 240] + 400 / half * (angle / across)[:, None] * at[:, :2] + noise_px * rng.normal(size=(48, 2))
        if np.all((pixels > 5) & (pixels < [635, 475])) and at[:, 2].min() > 0.01:
            wide.append(BoardView(f"{len(wide)}", pixels, CORNERS, np.arange(48)))
    return wide


def test_a_wide_lens_that_is_all_but_described_has_a_note():
    result = calibrate(seen(fisheye(120)))
    assert any("wider than its model" in note for note in result.notes)
    assert "k3" in result.free
    assert not any("wider" in note for note in calibrate(seen(fisheye(80))).notes)


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

    @pytest.mark.parametrize("degrees", [135, 150, 210])
    def test_a_fisheye(self, degrees: int):
        with pytest.raises(Refused, match="fisheye"):
            calibrate(seen(fisheye(degrees)))

    def test_a_lens_that_changed_between_pictures(self):
        # every other picture with another distortion: 1 px would be allowed if the noise did not tell
        zoomed = views(1, noise_px=0.03)
        middle = CAMERA[2:4]
        for i in range(0, 15, 2):
            at = zoomed[i].image_points
            r2 = np.sum((at - middle) ** 2, axis=1, keepdims=True) / 320**2
            zoomed[i] = replace(zoomed[i], image_points=middle + (at - middle) * (1.0 + 0.06 * r2))
        with pytest.raises(
            Refused, match=r"explains the corners: 0\.\d\d px rms, where the noise of the corners is 0\.04"
        ):
            calibrate(seen(zoomed))

    def test_a_line_of_corners(self):
        line = [
            replace(v, image_points=v.image_points[:8], object_points=v.object_points[:8], corner_ids=v.corner_ids[:8])
            for v in views()
        ]
        with pytest.raises(Refused, match="pictures: "):
            calibrate(seen(line))
