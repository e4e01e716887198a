"""Tables for other libraries count joints and cables as the columns' names do."""

import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identification.dataset.series import Series, numbered_columns
from xneck.export.tables import to_xarray


def test_joints_and_cables_are_counted_from_one(monkeypatch: pytest.MonkeyPatch) -> None:
    library: Any = ModuleType("xarray")
    library.Dataset = lambda variables, coords: SimpleNamespace(variables=variables, coords=coords)
    monkeypatch.setitem(sys.modules, "xarray", library)
    alpha, f = np.arange(6.0).reshape(2, 3), np.arange(8.0).reshape(2, 4)
    columns = {**numbered_columns("alpha", alpha), **numbered_columns("f", f), "led": np.ones(2)}
    cube = to_xarray(Series(np.array([0.0, 0.1]), columns))
    assert cube.coords["joint"].tolist() == [1, 2, 3]
    assert cube.coords["cable"].tolist() == [1, 2, 3, 4]
    dimensions, values = cube.variables["alpha"]
    assert dimensions == ("time", "joint")
    np.testing.assert_array_equal(values[:, cube.coords["joint"].tolist().index(2)], columns["alpha2"])
    assert cube.variables["led"][0] == "time"
