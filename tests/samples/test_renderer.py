"""The sample's renderer is exact where it matters: pixels, markers, boards, instants.

Edges are located by a method of this file's own: along a line across a straight edge between two levels, the mean of
(level - dark) / (bright - dark) tells where the edge is, whatever symmetric blur it went through.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import av
import cv2
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from samples.generator.board import board_poses, render_board, render_board_pictures
from samples.generator.camera import SAMPLE_CAMERA, Camera, pose
from samples.generator.frame import plates, render_frame
from samples.generator.linkage import solve
from samples.generator.printed import INK, PAPER, charuco_pattern, marker_pattern, seen
from samples.generator.scene import Shape
from samples.generator.trouble import Glare, Trouble
from samples.generator.video import Look, render_video

SMALL = SAMPLE_CAMERA.scaled(0.25)
FloatArray = NDArray[np.float64]


@pytest.fixture(scope="module")
def neck() -> dict[str, Any]:
    with open("samples/recording/neck.yaml") as file:
        return yaml.safe_load(file)


@pytest.fixture(scope="module")
def board() -> dict[str, Any]:
    with open("samples/recording/board.yaml") as file:
        return yaml.safe_load(file)


def edge_offsets(picture: NDArray[Any], ends: FloatArray, reach: float = 6.0) -> FloatArray:
    """How far a dark-to-bright edge lies from the straight line between `ends`, shape (2, 2), px, at places along it.

    Positive is towards the bright side, which must be to the left of ends[1] - ends[0] as seen in the picture.
    """
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    across = np.array([along[1], -along[0]])
    s = np.linspace(0.2, 0.8, 160)
    t = np.arange(-reach, reach + 1e-9, 0.1)
    places = (ends[0] + s[:, None] * (ends[1] - ends[0]))[:, None, :] + t[:, None] * across
    line = map_coordinates(picture.astype(float), [places[..., 1], places[..., 0]], order=1)
    dark, bright = line[:, :8].mean(axis=1), line[:, -8:].mean(axis=1)
    share = (line - dark[:, None]) / (bright - dark)[:, None]
    # where the step would have to be for the same mean
    return reach - 0.1 * (share[:, :-1] + share[:, 1:]).sum(axis=1) / 2


def black_corners(neck: dict[str, Any], alpha: FloatArray, camera: Camera) -> list[FloatArray]:
    """Exact corners of the black squares, clockwise from the top left, each of shape (4, 2), px."""
    found = []
    for plate in plates(alpha, neck):
        w, h = plate.pattern.extent
        corners = np.array([[0, 0], [w, 0], [w, h], [0, h]])
        found.append(camera.project(plate.points(corners)))
    return found


def mean_levels(alpha: FloatArray, neck: dict[str, Any], camera: Camera) -> FloatArray:
    """A picture without noise, mean of the colours, shape (h, w)."""
    return render_frame(alpha, neck, camera).mean(axis=-1)


# --- camera


def test_projection_is_opencvs() -> None:
    points = np.random.default_rng(0).uniform([-0.25, -0.05, -0.02], [0.25, 0.3, 0.02], (500, 3))
    camera = SAMPLE_CAMERA
    theirs, _ = cv2.projectPoints(
        points, np.array(camera.rotation), np.array(camera.translation), camera.matrix, camera.distortion
    )
    assert np.abs(camera.project(points) - theirs[:, 0]).max() < 1e-9


def test_pixel_to_plane_and_back() -> None:
    v, u = np.mgrid[0:720:7, 0:1280:7]
    pixels = np.stack([u, v], axis=-1).astype(float)
    assert np.abs(SAMPLE_CAMERA.project(SAMPLE_CAMERA.on_plane(pixels)) - pixels).max() < 1e-8


def test_arm_fits_the_picture(neck: dict[str, Any]) -> None:
    corners = np.array(black_corners(neck, np.zeros(3), SAMPLE_CAMERA))
    assert corners.min() > 40
    assert (corners < np.array([1280, 720]) - 40).all()
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    assert sides.min() > 54
    assert sides.max() < 68


# --- patterns


def test_a_pixels_mean_is_the_integral_over_its_area() -> None:
    """Against brute force: 64 x 64 points a pixel, on a turned pattern."""
    pattern = marker_pattern("apriltag_36h11", 2, 0.030)
    j, i = np.mgrid[0:40, 0:40].astype(float)
    turn, pitch = np.exp(0.3j), 0.030 / 25
    z = turn * ((i - 19.5) + 1j * (j - 19.5)) * pitch + (0.0151 + 0.0148j)
    value, cover = seen(pattern, np.stack([z.real, z.imag], axis=-1), samples=4)
    part = (np.arange(64) + 0.5) / 64 - 0.5
    fine = z[..., None, None] + turn * pitch * (part[:, None] + 1j * part)
    column, row = np.floor(fine.real / pattern.cell), np.floor(fine.imag / pattern.cell)
    padded = np.pad(pattern.cells, 1, constant_values=PAPER)
    exact = padded[np.clip(row + 1, 0, 9).astype(int), np.clip(column + 1, 0, 9).astype(int)].mean(axis=(-1, -2))
    a = pattern.paper[0]
    covered = ((fine.real > -a) & (fine.real < 0.030 + a) & (fine.imag > -a) & (fine.imag < 0.030 + a)).mean((-1, -2))
    assert np.abs(value - exact).max() < 0.02 * (PAPER - INK)
    assert abs((value - exact).mean()) < 1e-4 * (PAPER - INK)
    assert np.abs(cover - covered).max() < 0.02


def test_charuco_layout_is_opencvs(board: dict[str, Any]) -> None:
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    theirs = cv2.aruco.CharucoBoard((9, 6), 0.025, 0.0175, words).generateImage((180, 120), marginSize=0, borderBits=1)
    ours = charuco_pattern(board)
    assert ours.extent == pytest.approx((9 * 0.025, 6 * 0.025))
    assert np.array_equal(ours.cells > 0.5, theirs > 127)


def test_unknown_dictionary_names_what_there_is() -> None:
    with pytest.raises(ValueError, match="DICT_APRILTAG_36h11"):
        marker_pattern("apriltag_99", 0, 0.03)


# --- markers in frames


def mounted(neck: dict[str, Any]) -> dict[str, Any]:
    """The same arm with markers up to 8 mm before and behind its plane, and tilted by up to 3 deg."""
    off = [(0.008, (0.03, -0.05)), (-0.006, (0.0, 0.04)), (0.003, (-0.05, 0.0)), (-0.008, (0.02, 0.02))]
    on_bars = [
        m | {"depth": depth, "tilt": tilt} for m, (depth, tilt) in zip(neck["markers"]["on_bars"], off, strict=True)
    ]
    return neck | {"markers": neck["markers"] | {"on_bars": on_bars}}


@pytest.mark.parametrize("mounting", [dict, mounted])
def test_edges_of_markers_are_where_they_are_projected(
    neck: dict[str, Any], mounting: Callable[[dict[str, Any]], dict[str, Any]]
) -> None:
    """Over 16 edges: no mean shift beyond 0.005 px in any direction, and none of them beyond 0.03 px.

    Within 60 px the lens bends a straight line by less than 0.02 px, which the chord of the corners leaves out.
    """
    neck = mounting(neck)
    alpha = np.radians([17.0, -23.0, 31.0])
    picture = mean_levels(alpha, neck, SAMPLE_CAMERA)
    outward, shifts = [], []
    for corners in black_corners(neck, alpha, SAMPLE_CAMERA):
        for a, b in pairwise([*corners, corners[0]]):
            offset = float(edge_offsets(picture, np.array([a, b]), reach=4.0).mean())
            outward.append(offset)
            shifts.append(offset * np.array([b[1] - a[1], a[0] - b[0]]) / np.linalg.norm(b - a))
    assert np.abs(outward).max() < 0.03
    assert abs(np.mean(outward)) < 0.01  # neither bolder nor thinner
    assert np.abs(np.mean(shifts, axis=0)).max() < 0.005  # nor displaced


@pytest.mark.parametrize("field", ["cx", "cy"])
def test_edges_tell_a_camera_that_is_off_by_a_tenth_of_a_pixel(neck: dict[str, Any], field: str) -> None:
    """Negative control: the same measurement against corners projected 0.1 px off."""
    alpha = np.radians([17.0, -23.0, 31.0])
    picture = mean_levels(alpha, neck, SAMPLE_CAMERA)
    wrong = np.array([0.1, 0.0] if field == "cx" else [0.0, 0.1])
    shifts = []
    for corners in black_corners(neck, alpha, SAMPLE_CAMERA):
        for a, b in pairwise([*(corners + wrong), corners[0] + wrong]):
            offset = float(edge_offsets(picture, np.array([a, b]), reach=4.0).mean())
            shifts.append(offset * np.array([b[1] - a[1], a[0] - b[0]]) / np.linalg.norm(b - a))
    assert np.mean(shifts, axis=0) == pytest.approx(-wrong / 2, abs=0.01)  # half of the edges lie along the shift


def test_markers_are_found_upright_on_their_bars(neck: dict[str, Any]) -> None:
    alpha = np.radians([-28.0, 15.0, 22.0])
    grey = cv2.cvtColor(render_frame(alpha, neck, SAMPLE_CAMERA, np.random.default_rng(0)), cv2.COLOR_RGB2GRAY)
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    corners, ids, _ = cv2.aruco.ArucoDetector(words).detectMarkers(grey)
    found = {int(i): c.reshape(4, 2) for i, c in zip(np.ravel(ids), corners, strict=True)}
    assert sorted(found) == [0, 1, 2, 3]
    for number, exact in enumerate(black_corners(neck, alpha, SAMPLE_CAMERA)):
        assert np.abs(found[number] - exact).max() < 1.5  # the order of corners is at stake, not their accuracy


def test_markers_placement_is_followed(neck: dict[str, Any]) -> None:
    """`at` and `angle` are of the bar's frame: 2 mm along a bar that stands at 90 degrees is 2 mm upwards."""
    moved = {**neck, "markers": {**neck["markers"], "on_bars": [{"id": 1, "bar": 1, "at": [0.002, 0.0], "angle": 0.1}]}}
    alpha = np.radians([90.0, 0.0, 0.0])
    plate, unmoved = plates(alpha, moved)[0], plates(alpha, neck)[1]
    assert plate.place - unmoved.place == pytest.approx(0.002j, abs=1e-12)
    assert plate.angle == pytest.approx(np.pi / 2 + 0.1)


def test_a_marker_out_of_the_plane_is_nearer_and_foreshortened(neck: dict[str, Any]) -> None:
    """Tilted about its own x axis by 60 degrees a square is half as high, its upper side nearer by 13 mm; 8 mm of depth add."""
    on = neck["markers"]["on_bars"][0] | {"depth": 0.008, "tilt": (np.radians(60.0), 0.0)}
    (plate,) = plates(np.zeros(3), neck | {"markers": neck["markers"] | {"on_bars": [on]}})
    (w, h), lift = plate.pattern.extent, plate.pattern.extent[1] / 2 * np.sin(np.radians(60.0))
    corners = plate.points(np.array([[0, 0], [w, 0], [w, h], [0, h]]))
    exact = [[-w / 2, h / 4, 0.008 + lift], [w / 2, h / 4, 0.008 + lift]]
    exact += [[w / 2, -h / 4, 0.008 - lift], [-w / 2, -h / 4, 0.008 - lift]]
    np.testing.assert_allclose(corners, exact, atol=1e-12)


def test_markers_on_diagonals_are_on_the_line_between_the_bars_ends(neck: dict[str, Any]) -> None:
    """A2 joins the lower left and the upper right end, B2 the others; 5 mm along it is 5 mm nearer to its upper end."""
    on_bars = [
        {"id": 1, "diagonal": "A2"},
        {"id": 2, "diagonal": "B2"},
        {"id": 3, "diagonal": "B2", "at": [0.005, 0.0]},
    ]
    alpha = np.radians([30.0, -20.0, 10.0])
    laid = plates(alpha, {**neck, "markers": {**neck["markers"], "on_bars": on_bars}})
    bars = solve(alpha, np.full(3, 0.10), np.full(3, 0.05))
    for plate, low, high in (
        (laid[0], bars.left[1], bars.right[2]),
        (laid[1], bars.right[1], bars.left[2]),
    ):
        assert plate.place == pytest.approx((low + high) / 2, abs=1e-12)
        assert np.exp(1j * plate.angle) == pytest.approx((high - low) / 0.10, abs=1e-9)
    assert abs(laid[2].place - bars.left[2]) == pytest.approx(0.045, abs=1e-12)


def test_what_is_in_front_hides_and_a_shadow_dims(neck: dict[str, Any]) -> None:
    """Inside an outline a thing's own level, or a share of the light; outside nothing changes, to the grey level."""
    box = np.array([-0.004 - 0.004j, 0.004 - 0.004j, 0.004 + 0.004j, -0.004 + 0.004j])
    plain = mean_levels(np.zeros(3), neck, SAMPLE_CAMERA)
    x, y = np.rint(SAMPLE_CAMERA.project(np.zeros(2))).astype(int)
    for suffers, least, most in (
        (Trouble(in_front=(Shape(box, (0.5, 0.5, 0.5)),)), 90, 140),
        (Trouble(shadows=(Shape(box, (0.25, 0.25, 0.25)),)), 0, 64),
        (Trouble(glare=(Glare(0j, 0.001, 1.2),)), 250, 255),
    ):
        spoilt = render_frame(np.zeros(3), neck, SAMPLE_CAMERA, suffers=suffers).mean(axis=-1)
        assert least <= spoilt[y - 1 : y + 2, x - 1 : x + 2].mean() <= most
        far = np.hypot(*(np.mgrid[:720, :1280] - np.array([y, x])[:, None, None])) > 25
        np.testing.assert_array_equal(spoilt[far], plain[far])


def test_an_arm_without_markers_shows_none(neck: dict[str, Any]) -> None:
    bare = {key: value for key, value in neck.items() if key != "markers"}
    picture = cv2.cvtColor(render_frame(np.zeros(3), bare, SAMPLE_CAMERA), cv2.COLOR_RGB2GRAY)
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    assert not cv2.aruco.ArucoDetector(words).detectMarkers(picture)[0]


def test_blur_is_symmetric_about_the_middle_of_the_exposure(neck: dict[str, Any]) -> None:
    """An arm that sweeps 0.3 degrees (3 px at the top) in one exposure: edges stay where they are at its middle.

    The markers have cells of 10 px, so that the blurs of neighbouring edges keep apart.
    """
    wide = {**neck, "markers": {**neck["markers"], "dictionary": "aruco_4x4_50"}}
    alpha = np.radians([20.0, -10.0, 15.0])
    sweep = np.radians([0.3, 0.0, 0.0])
    parts = (np.arange(9) + 0.5) / 9 - 0.5
    right = black_corners(wide, alpha, SAMPLE_CAMERA)[3][1:3]  # the edge that the sweep moves across itself
    for late, expected in ((0.0, 0.0), (0.1, 0.1)):  # and, as a control, a tenth of an exposure late
        seen_at = mean_levels(alpha + (parts[:, None] + late) * sweep, wide, SAMPLE_CAMERA)
        moved = (black_corners(wide, alpha + expected * sweep, SAMPLE_CAMERA)[3][1:3] - right).mean(axis=0)
        along = (right[1] - right[0]) / np.linalg.norm(right[1] - right[0])
        across = moved @ [along[1], -along[0]]
        assert edge_offsets(seen_at, right, reach=4.5).mean() == pytest.approx(across, abs=0.03)
        assert (abs(across) > 0.2) == (late > 0)


# --- video


def motion(t: float) -> FloatArray:
    return np.radians([20 * np.sin(2 * t), 15 * np.sin(3 * t + 1), 10 * np.sin(5 * t)])


@pytest.fixture(scope="module")
def times() -> FloatArray:
    t = 0.31 + np.arange(45) / 30 + np.random.default_rng(1).uniform(-3e-4, 3e-4, 45)
    return np.delete(t, [7, 8, 30])


def test_stamps_read_back(neck: dict[str, Any], times: FloatArray, tmp_path: Any) -> None:
    path = tmp_path / "arm.mp4"
    render_video(path, times, motion, neck, SMALL, seed=5)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        frames = list(container.decode(stream))
        read = np.array([float(f.pts * stream.time_base) for f in frames if f.pts is not None and stream.time_base])
        assert stream.frames == len(times)
        assert not stream.codec_context.has_b_frames
    assert np.abs(read - times).max() <= 0.5 / 90_000 + 1e-12
    keys = read[[f.key_frame for f in frames]]
    assert keys[0] == read[0]
    assert np.diff(np.append(keys, read[-1])).max() <= 1.0


def test_the_same_seed_gives_the_same_bytes(neck: dict[str, Any], times: FloatArray, tmp_path: Any) -> None:
    """Also with more processes; another seed gives others."""
    for name, seed, processes in (("a", 5, 1), ("b", 5, 2), ("c", 6, 1)):
        render_video(tmp_path / f"{name}.mp4", times[:12], motion, neck, SMALL, seed, processes=processes)
    a, b, c = ((tmp_path / f"{name}.mp4").read_bytes() for name in "abc")
    assert a == b
    assert a != c


def test_markers_survive_the_encoder(neck: dict[str, Any], times: FloatArray, tmp_path: Any) -> None:
    """At full size, in luma as a reader gets it; and frame k of the file is the arm at times[k]."""
    path = tmp_path / "arm.mp4"
    render_video(path, times[:10], motion, neck, SAMPLE_CAMERA, seed=5, look=Look(instants=3))
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    detector = cv2.aruco.ArucoDetector(words)
    with av.open(str(path)) as container:
        for t, frame in zip(times[:10], container.decode(video=0), strict=True):
            corners, ids, _ = detector.detectMarkers(np.ascontiguousarray(frame.to_ndarray()[: frame.height]))
            found = {int(i): c.reshape(4, 2).mean(axis=0) for i, c in zip(np.ravel(ids), corners, strict=True)}
            assert sorted(found) == [0, 1, 2, 3]
            for number, exact in enumerate(black_corners(neck, motion(t), SAMPLE_CAMERA)):
                assert np.abs(found[number] - exact.mean(axis=0)).max() < 0.8


def test_times_that_do_not_increase_are_refused(neck: dict[str, Any], tmp_path: Any) -> None:
    with pytest.raises(ValueError, match="increase"):
        render_video(tmp_path / "no.mp4", [0.0, 0.1, 0.1], motion, neck, SMALL, seed=0)
    assert not (tmp_path / "no.mp4").exists()


# --- board


def test_edges_of_the_board_are_where_they_are_projected(board: dict[str, Any]) -> None:
    """The left and upper sides of the first, black square and the edges opposite it, in a tilted view without noise."""
    pattern = charuco_pattern(board)
    T = board_poses(pattern, SAMPLE_CAMERA, seed=3, count=4)[2]
    picture = render_board(pattern, T, SAMPLE_CAMERA, None)
    w, h = pattern.extent
    s = board["square"]
    clockwise = np.array([[[0, s], [0, 0]], [[0, 0], [s, 0]], [[w - s, h], [w - 2 * s, h]], [[w, s], [w, 2 * s]]])
    ends = SAMPLE_CAMERA.project_from(T, np.concatenate([clockwise, np.zeros((4, 2, 1))], axis=-1))
    dark = [edge_offsets(picture, e, reach=4.0).mean() for e in ends if _is_dark_inside(picture, e)]
    assert len(dark) >= 2
    assert np.abs(dark).max() < 0.05


def _is_dark_inside(picture: NDArray[Any], ends: FloatArray) -> bool:
    """Whether the right side of an edge, seen along it, is printed black."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    x, y = ends.mean(axis=0) + 5 * np.array([-along[1], along[0]])
    return bool(picture[round(y), round(x)] < 40)


def test_board_pictures_calibrate_the_camera(board: dict[str, Any], tmp_path: Any) -> None:
    """With OpenCV alone, on all 20 pictures: the focal length to 2 px, and every part of the picture is used."""
    truth = render_board_pictures(tmp_path, board, SAMPLE_CAMERA, seed=7)
    assert sum(path.stat().st_size for path in tmp_path.glob("*.jpg")) < 3e6
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    layout = cv2.aruco.CharucoBoard((9, 6), 0.025, 0.0175, words)
    detector = cv2.aruco.CharucoDetector(layout)
    points, pixels, errors = [], [], []
    for entry in truth:
        grey = cv2.imread(str(tmp_path / entry["file"]), cv2.IMREAD_GRAYSCALE)
        assert grey is not None
        corners, ids, _, _ = detector.detectBoard(grey)
        numbers = np.ravel(ids).astype(int)
        assert len(numbers) >= 12
        corners = cv2.cornerSubPix(grey, corners.reshape(-1, 1, 2), (5, 5), (-1, -1), (3, 40, 1e-3))
        known = np.array(layout.getChessboardCorners(), dtype=np.float32)[numbers]
        exact = SAMPLE_CAMERA.project_from(pose(entry["rotation"], entry["translation"]), known.astype(float))
        errors.append(corners[:, 0] - exact)
        points.append(known)
        pixels.append(corners)
    assert np.sqrt(np.mean(np.concatenate(errors) ** 2)) < 0.1
    assert np.abs(np.concatenate(errors).mean(axis=0)).max() < 0.01  # pictures and pixel convention agree
    start = np.array([[1000.0, 0, 640], [0, 1000, 360], [0, 0, 1]])
    _, matrix, _, _, _ = cv2.calibrateCamera(points, pixels, SAMPLE_CAMERA.size, start, np.zeros(5))
    assert np.abs(matrix - SAMPLE_CAMERA.matrix).max() < 2.0
    everywhere = np.concatenate(pixels)[:, 0] * [4, 3] / SAMPLE_CAMERA.size
    assert np.histogram2d(*everywhere.T, bins=(4, 3), range=((0, 4), (0, 3)))[0].min() >= 8
