from pathlib import Path

import numpy as np
import pytest

from calibration.dictionaries import dictionary_names, dictionary_size, marker_cells
from calibration.dictionary_file import read_dictionary
from xneck_foundation.errors import Refused


def test_names_are_opencvs_in_lower_case():
    names = dictionary_names()
    assert {"aruco_4x4_50", "aruco_5x5_100", "aruco_original", "aruco_mip_36h12", "apriltag_36h11"} <= set(names)
    assert all(name == name.lower() for name in names)
    assert dictionary_size("aruco_5x5_100") == 100
    assert dictionary_size("apriltag_36h11") == 587


def test_an_unknown_name_lists_the_valid_ones():
    with pytest.raises(Refused, match=r"unknown dictionary 'dict_5x5_100'; did you mean aruco_5x5_100\?"):
        marker_cells("dict_5x5_100", 0)


@pytest.mark.parametrize("marker_id", [-1, 587])
def test_an_id_outside_the_dictionary_is_refused(marker_id: int):
    with pytest.raises(Refused, match="ids 0 to 586"):
        marker_cells("apriltag_36h11", marker_id)


def test_apriltags_are_turned_by_180_degrees_against_the_official_codewords():
    cells = marker_cells("apriltag_36h11", 0)
    assert cells.shape == (8, 8)
    assert cells[0].all()
    assert cells[:, -1].all()
    bits = np.rot90(~cells[1:-1, 1:-1], 2).ravel()
    assert int("".join("01"[int(bit)] for bit in bits), 2) == 0xD5D628584  # tag36h11's first codeword


FILE = """
xneck: 1
cells: 3
corrected_cells: 0
markers:
  - ["#..", "##.", "..#"]
  - ["###", "#.#", "..#"]
"""


def read(folder: Path, text: str) -> tuple[np.ndarray, int]:
    path = folder / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return read_dictionary(path)


def test_a_file_gives_the_cells_as_they_are_drawn(tmp_path: Path):
    white, corrected = read(tmp_path, FILE)
    assert corrected == 0
    np.testing.assert_array_equal(white[0], [[False, True, True], [False, False, True], [True, True, False]])


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('"##."', '"##"', r"markers\[0\]: expected 3 rows of 3 cells"),
        ('"##."', '"##x"', r"markers\[0\]: expected 3 rows of 3 cells"),
        (
            '"#..", "##.", "..#"',
            '"###", "#.#", "###"',
            "marker 0 turned differs in 0 cells where corrected_cells: 0 needs 1",
        ),
        ("corrected_cells: 0", "corrected_cells: 3", "corrected_cells: 3 needs 7"),
        ("cells: 3\n", "cells: 2\n", "cells"),
    ],
)
def test_a_file_that_would_not_be_read_reliably_is_refused(before: str, after: str, words: str, tmp_path: Path):
    with pytest.raises(Refused, match=words):
        read(tmp_path, FILE.replace(before, after, 1))


def test_a_turned_copy_of_another_marker_is_refused(tmp_path: Path):
    rows = np.rot90([list(row) for row in ("#..", "##.", "..#")])
    turned = ", ".join('"' + "".join(row) + '"' for row in rows)
    with pytest.raises(Refused, match="markers 0 and 1 differ in 0 cells"):
        read(tmp_path, FILE.replace('"###", "#.#", "..#"', turned))
