"""The oldest dependencies that CI tries are those of pyproject.toml, each one of them."""

import importlib.util
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.paths import ROOT

_spec = importlib.util.spec_from_file_location("lower_bounds", ROOT / ".ci/lower_bounds.py")
assert _spec is not None
assert _spec.loader is not None
ci = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ci)


def project(folder: Path, dependencies: str) -> Path:
    (folder / "pyproject.toml").write_text(f"[project]\ndependencies = {dependencies}\n", encoding="utf-8")
    return folder / "pyproject.toml"


def test_every_dependency_is_held_to_its_lower_bound(tmp_path: Path) -> None:
    found = ci.lower_bounds(project(tmp_path, '["numpy>=2.1,<3", "a-b.c[x]>=0.22"]'))
    assert found == ["numpy==2.1.*", "a-b.c==0.22.*"]
    with pytest.raises(ValueError, match="scipy<2: no lower bound"):
        ci.lower_bounds(project(tmp_path, '["numpy>=2.1", "scipy<2"]'))


def test_the_projects_own_bounds_are_all_of_them_and_within_what_it_allows() -> None:
    held = ci.lower_bounds(ROOT / "pyproject.toml")
    assert {Requirement(one).name for one in held} >= {"numpy", "scipy", "opencv-contrib-python-headless", "av", "dask"}
    assert len(held) == len({Requirement(one).name for one in held})


def test_development_tools_have_one_exact_version_each() -> None:
    lines = (ROOT / ".ci/dev-tools.txt").read_text(encoding="utf-8").split()
    tools = {Requirement(line).name: str(Requirement(line).specifier) for line in lines}
    assert len(tools) == len(lines)
    assert all(version.startswith("==") and "*" not in version for version in tools.values())
    assert {"pytest", "ruff", "pyright", "import-linter", "hypothesis", "pytest-xdist"} <= set(tools)
    assert {"numpy", "scipy", "av"}.isdisjoint(tools)
