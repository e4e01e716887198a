"""Markers that nobody here made, found by ours, OpenCV and pyapriltags: counts, jitter at rest, and how they fit known layouts.

The files are those of AprilTag, OpenCV's samples and scikit-surgeryarucotracker, in `shared/data/markers` beside the checkout.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.apriltag import FAMILIES, apriltags
from benchmarks.marker_angle import in_plane_angle
from benchmarks.opencv import REFINEMENTS, searching
from benchmarks.table import Claim, Table
from calibration.dictionaries import marker_cells, opencv_dictionary
from mechanism.printed_markers import BarMarker, Markers
from vision.markers.detection import MarkerDetector
from vision.markers.photometric import MarkerStart, fit_markers
from vision.markers.template import Optics
from vision.markers.tracking import MarkerTracker, TrackingOptions
from vision.video import Frame, read_frames

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Corners = dict[int, Array]
"""of one picture, (4, 2) px by id"""
Figures = tuple[float | None, ...]

DATA = Path(__file__).parents[2] / "shared/data/markers"
SURGERY = DATA / "scikit_surgery"
METHODS = ("edges", "template", *(f"OpenCV {name}" for name in REFINEMENTS), "pyapriltags")
PEERS = ("OpenCV SUBPIX", "pyapriltags")
"""named in the summary"""
STILLS = ("singlemarkersoriginal", "chocclusion_original", "img_00", "img_01", "img_02", "img_03")
"""OpenCV's samples, of aruco_6x6_250"""
LAYOUTS = ("reference.txt", "pointer.txt")
NEAR = 4.0
"""px between middles, within which a tag is the published one"""
LEAST = 3
"""markers of a layout in a picture, below which its fit says little"""


def measure() -> Table:
    """A row a file and figure, a column a method."""
    if not DATA.is_dir():
        return Table("Real markers: skipped, as their files are not there", METHODS, ())
    layouts = {name: _layout(SURGERY / name) for name in LAYOUTS}
    known = sorted({i for layout in layouts.values() for i in layout})
    photographs, claims = _photographs()
    rows = _stills()
    rows += _video("multipattern.avi", "aruco_original", known, layouts)
    rows += _video("output.avi", "aruco_4x4_50", [0], {})
    rows += _video("12markers.avi", "aruco_6x6_250", list(range(1, 13)), {})
    title = (
        "Real markers: how many are found; noise of the angle of markers seen in every picture, by its second differences;\n"
        "RMS of the corners about the flat layout they were printed in, freely placed; the same markers for every method"
    )
    return Table(title, METHODS, (*photographs, *rows), claims)


def _photographs() -> tuple[list[tuple[str, Figures]], tuple[Claim, ...]]:
    """AprilTag's pictures, each tag many times over: those found near published ones, and the median of their corners' errors.

    Claims are of the fit that is ours by default.
    """
    pictures = sorted((DATA / "apriltag").glob("*.jpg"))
    ways = _all_in_picture("apriltag_36h11", 587)
    truth = [_published(picture) for picture in pictures]
    found: list[float | None] = []
    off: list[float | None] = []
    for way in ways:
        if way is None:
            found.append(None)
            off.append(None)
            continue
        errors = []
        for picture, tags in zip(pictures, truth, strict=True):
            seen = way(_grey(picture))
            for tag in tags:
                near = [c for c in seen if np.linalg.norm(c.mean(axis=0) - tag.mean(axis=0)) < NEAR]
                turns = [np.roll(c[::way_round], k, axis=0) for c in near for k in range(4) for way_round in (1, -1)]
                errors += [min(float(np.abs(c - tag).max()) for c in turns)] if near else []
        found.append(len(errors))
        off.append(float(np.median(errors)))
    count = sum(len(tags) for tags in truth)
    missed = [None if n is None else count - n for n in found]
    claims = [
        Claim(what, "AprilTag's photographs", dict(zip(METHODS, figures, strict=True))["template"], (peer, theirs))
        for what, figures in ((f"tags missed of {count}", missed), ("worst corner of a tag, median, px", off))
        for peer, theirs in zip(METHODS, figures, strict=True)
        if peer in PEERS
    ]
    return [(f"photographs, found of {count}", tuple(found)), ("  worst corner, median px", tuple(off))], tuple(claims)


def _stills() -> list[tuple[str, Figures]]:
    ways = _all_in_picture("aruco_6x6_250", 250)
    pictures = {name: _grey(DATA / f"opencv_aruco/{name}.jpg") for name in STILLS}
    return [
        (f"{name}.jpg, found", tuple(None if way is None else len(way(grey)) for way in ways))
        for name, grey in pictures.items()
    ]


def _video(name: str, family: str, ids: list[int], layouts: dict[str, Corners]) -> list[tuple[str, Figures]]:
    """Ours as it follows a recording, the others picture by picture."""
    shown = list(read_frames(SURGERY / name))
    ways = [_followed(family, ids, shown, template) for template in (False, True)]
    for refinement in REFINEMENTS:
        find = searching(family, refinement)
        ways.append([{i: c for i, c in find(frame.grey).items() if i in ids} for frame in shown])
    counts = [sum(len(one) for one in way) for way in ways]
    rows: list[tuple[str, Figures]] = [(f"{name}, found in {len(shown)}", (*counts, None))]
    shared = [set.intersection(*(set(way[k]) for way in ways)) for k in range(len(shown))]
    always = sorted(set.intersection(*shared))
    if len(shown) > 2 and always:
        rows.append((f"  {len(always)} jitter, deg", (*(_jitter(way, always) for way in ways), None)))
    for layout, plate in layouts.items():
        common = [sorted(one & set(plate)) for one in shared]
        if max(map(len, common)) >= LEAST:
            rows.append((f"  on {layout}, px", (*(_misfit(way, plate, common) for way in ways), None)))
    return rows


def _all_in_picture(family: str, count: int) -> list[Callable[[Grey], list[Array]] | None]:
    """Corners of all markers of a picture, by each method; None where it does not know the dictionary."""
    detector = MarkerDetector(
        Markers(dictionary=family, size=0.02, on_bars=tuple(BarMarker(id=i, bar=0) for i in range(count)))
    )

    def every(grey: Grey) -> list[tuple[int, Array]]:
        """With those that are found only where small ones are searched, as `extract` does for one that is missing."""
        plain = detector.detect_all(grey)
        middles = np.array([c.mean(axis=0) for _, c in plain]).reshape(-1, 2)
        small = [
            (i, c)
            for i, c in detector.detect_small(grey)
            if np.all(np.linalg.norm(middles - c.mean(axis=0), axis=1) > NEAR)
        ]
        return plain + small

    def template(grey: Grey) -> list[Array]:
        rest = np.zeros((4, 2))
        starts = [MarkerStart(c, marker_cells(family, i), rest) for i, c in every(grey)]
        return [fit.corners for fit in fit_markers(grey, starts, Optics())]

    def opencv(refinement: str) -> Callable[[Grey], list[Array]]:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = REFINEMENTS[refinement]
        detector = cv2.aruco.ArucoDetector(opencv_dictionary(family), parameters)
        return lambda grey: [np.asarray(c, dtype=float).reshape(4, 2) for c in detector.detectMarkers(grey)[0]]

    ours = [lambda grey: [c for _, c in every(grey)], template]
    return [*ours, *(opencv(name) for name in REFINEMENTS), _apriltags(family)]


def _followed(family: str, ids: list[int], shown: list[Frame], template: bool) -> list[Corners]:
    """As a recording of markers on a bar."""
    on_bars = tuple(BarMarker(id=i, bar=0) for i in ids)
    tracker = MarkerTracker(Markers(dictionary=family, size=0.02, on_bars=on_bars), TrackingOptions(template))
    seen = [tracker.track(frame).corners for frame in shown]
    return [{i: c for i, c in zip(ids, one, strict=True) if np.isfinite(c).all()} for one in seen]


def _apriltags(family: str) -> Callable[[Grey], list[Array]] | None:
    if family not in FAMILIES:
        return None
    find = apriltags(family, decimate=1.0)
    return lambda grey: [corners for _, corners in find(grey)]


def _published(picture: Path) -> list[Array]:
    """Corners of a photograph's tags, (4, 2), pixel edges at integers, turned to pixel centres at integers."""
    rows = [line for line in picture.with_suffix(".txt").read_text().splitlines() if line.strip()]
    cells = [row.split(",", 1)[1].replace("(", " ").replace(")", " ").replace(",", " ").split() for row in rows]
    return [np.array(c, dtype=float).reshape(4, 2) - 0.5 for c in cells]


def _grey(path: Path) -> Grey:
    return np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)


def _layout(path: Path) -> Corners:
    """Corners of each marker of a rigid plate, mm: the file has id, middle and four corners with three coordinates each."""
    return {int(row[0]): row[4:].reshape(4, 3)[:, :2] for row in np.loadtxt(path)}


def _jitter(found: list[Corners], ids: list[int]) -> float:
    """Noise of an angle, deg: RMS of second differences over sqrt(6), which even motion leaves alone."""
    angles = np.unwrap([[in_plane_angle(one[i]) for i in ids] for one in found], axis=0)
    return float(np.degrees(np.sqrt(np.mean(np.diff(angles, 2, axis=0) ** 2) / 6)))


def _misfit(found: list[Corners], layout: dict[int, Array], common: list[list[int]]) -> float:
    """RMS per coordinate, px, about the layout's picture: a homography, so that no camera need be known."""
    off = []
    for one, ids in zip(found, common, strict=True):
        if len(ids) >= LEAST:
            plate, seen = (np.concatenate([corners[i] for i in ids]) for corners in (layout, one))
            H, _ = cv2.findHomography(plate, seen)
            off.append(cv2.perspectiveTransform(plate[None], H)[0] - seen)
    return float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
