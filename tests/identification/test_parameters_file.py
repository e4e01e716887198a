"""What was identified, as MATLAB and as a next neck.yaml read it."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from identification.parameters_file import write_mat, write_neck
from mechanism.description import read_neck
from tests.identification.test_estimates import NECK
from xneck_foundation.errors import Refused
from xneck_foundation.parameter import Parameter


def parameters(x0: float = 0.0051) -> list[Parameter]:
    k = [
        Parameter(name="k", index=j, value=1000.0 * j, unit="N/m", sigma=2.0 * j, identified=j != 3)
        for j in (1, 2, 3, 4)
    ]
    of_cables = [
        Parameter(name="x0", index=j, value=x0 + 1e-4 * j, unit="m", sigma=1e-5, identified=j != 2)
        for j in (1, 2, 3, 4)
    ]
    return [
        *k,
        Parameter(name="cm", index=None, value=0.5, unit="s/rad", sigma=float("inf"), identified=False),
        *of_cables,
    ]


def test_matlab_finds_columns_by_the_names_of_the_seed(tmp_path: Path) -> None:
    path = tmp_path / "model.mat"
    write_mat(parameters(), ("dry_friction", "linear_cable"), path)
    found = loadmat(path, simplify_cells=False)
    k = found["parameters"]["k"][0, 0]
    np.testing.assert_array_equal(k["value"][0, 0], [[1000.0], [2000.0], [3000.0], [4000.0]])
    np.testing.assert_array_equal(k["sigma"][0, 0].ravel(), [2, 4, 6, 8])
    np.testing.assert_array_equal(k["identified"][0, 0].ravel(), [1, 1, 0, 1])
    assert k["unit"][0, 0] == "N/m"
    assert found["parameters"]["cm"][0, 0]["sigma"][0, 0] == np.inf
    assert [str(name[0]) for name in found["laws"].ravel()] == ["dry_friction", "linear_cable"]


def test_the_next_neck_yaml_has_what_was_identified_and_keeps_the_rest(tmp_path: Path) -> None:
    path = tmp_path / "neck.yaml"
    write_neck(NECK, parameters(), "monday.mcap", path)
    found = read_neck(path)
    wanted = [0.0052, NECK.cables[1].x0, 0.0054, 0.0055]
    np.testing.assert_allclose([cable.x0 for cable in found.cables], wanted, rtol=1e-12)
    as_before = found.model_copy(
        update={
            "cables": tuple(c.model_copy(update={"x0": o.x0}) for c, o in zip(found.cables, NECK.cables, strict=True))
        }
    )
    assert as_before == NECK
    assert "monday.mcap" in path.read_text().splitlines()[0]


def test_a_neck_yaml_that_could_not_be_read_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"cables\[0\]\.x0"):
        write_neck(NECK, parameters(0.06), "monday.mcap", tmp_path / "neck.yaml")
    with pytest.raises(Refused, match="no pre-elongation"):
        write_neck(NECK, parameters()[:5], "monday.mcap", tmp_path / "neck.yaml")
    assert not list(tmp_path.iterdir())
