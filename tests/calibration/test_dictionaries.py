import numpy as np
import pytest

from calibration.dictionaries import dictionary_names, dictionary_size, marker_cells
from xneck_foundation.errors import Refused


def test_names_are_opencvs_in_lower_case():
    names = dictionary_names()
    assert {"aruco_4x4_50", "aruco_5x5_100", "aruco_original", "aruco_mip_36h12", "apriltag_36h11"} <= set(names)
    assert all(name == name.lower() for name in names)
    assert dictionary_size("aruco_5x5_100") == 100
    assert dictionary_size("apriltag_36h11") == 587


def test_an_unknown_name_lists_the_valid_ones():
    with pytest.raises(Refused, match=r"unknown dictionary 'dict_5x5_100'; valid: .*aruco_5x5_100"):
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
