"""docs/new-dictionary.md, followed in a copy of the sources, gives markers that are printed and detected."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import pytest
import yaml

from tests.calibration.truth import raster, svg_blacks
from tests.docs.pages import PAGES, ROOT, commands, fenced

PAGE = "new-dictionary.md"
SOURCES = ("xneck", "vision", "synchronisation", "identification", "calibration", "mechanism", "xneck_foundation")
PER_MM = 8

DETECT = """
import json, sys, cv2
from mechanism.description import markers_of, read_neck
from vision.markers.detection import MarkerDetector
detected = MarkerDetector(markers_of(read_neck(sys.argv[1]), sys.argv[1])).detect(cv2.imread(sys.argv[2], 0))
print(json.dumps({i: corners.tolist() for i, corners in detected.corners.items()}))
"""


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    """The page's files by their paths."""
    return {
        first.removeprefix("# "): text
        for first, text in (block.split("\n", 1) for block in fenced(PAGE, "yaml") if block.startswith("# "))
    }


@pytest.fixture(scope="module")
def followed(files: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources with the page's dictionary in them, and the sample's arm with markers of it."""
    folder = tmp_path_factory.mktemp("copy")
    for name in SOURCES:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path, text in files.items():
        (folder / path).write_text(text, encoding="utf-8")
    (name,) = (Path(path).stem for path in files)
    assert f"`dictionary: {name}`" in PAGES[PAGE]
    neck = (ROOT / "samples/recording/neck.yaml").read_text(encoding="utf-8")
    assert neck.count("apriltag_36h11") == 1
    (folder / "neck.yaml").write_text(neck.replace("apriltag_36h11", name), encoding="utf-8")
    return folder


def called(folder: Path, *words: object) -> str:
    """What Python prints there, with what is there before what is installed."""
    environment = os.environ | {"PYTHONPATH": str(folder)}
    call = [sys.executable, *map(str, words)]
    done = subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_one_new_file_is_enough(files: dict[str, str]) -> None:
    assert len(files) == 1
    assert not fenced(PAGE, "python")
    assert not fenced(PAGE, "diff")


def test_the_printed_markers_are_those_drawn_and_are_detected_with_their_ids(
    files: dict[str, str], followed: Path
) -> None:
    """`xneck board` as on the page, but for an SVG, which is read back pixel by pixel."""
    (line,) = (line for line in commands(PAGE) if " board " in line)
    words = line.replace("markers.pdf", "markers.svg").split()[1:]
    called(followed, "-m", "xneck", *words)
    size, shapes = svg_blacks(followed / "markers.svg")
    sheet = raster(size, shapes, PER_MM)
    cv2.imwrite(str(followed / "sheet.png"), sheet)
    corners = json.loads(called(followed, "-c", DETECT, "neck.yaml", "sheet.png"))
    drawn = yaml.safe_load(next(iter(files.values())))
    on_arm = [marker["id"] for marker in yaml.safe_load((followed / "neck.yaml").read_text())["markers"]["on_bars"]]
    assert sorted(map(int, corners)) == sorted(on_arm)
    cells = drawn["cells"] + 2
    for i in on_arm:
        left, top = corners[str(i)][0]
        right, bottom = corners[str(i)][2]
        for row, text in enumerate(drawn["markers"][i], start=1):
            for column, cell in enumerate(text, start=1):
                x, y = (a + (k + 0.5) / cells * (b - a) for a, b, k in ((left, right, column), (top, bottom, row)))
                assert (sheet[round(y), round(x)] < 128) == (cell == "#"), f"marker {i}, row {row}, column {column}"
