"""The digest of the sources is of every package that computes, so that no result of other code is taken for one of this."""

import tomllib
from pathlib import Path

import pytest

from xneck_foundation import source_digest as module
from xneck_foundation.source_digest import source_digest

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


@pytest.mark.parametrize(
    "package", tomllib.loads(PYPROJECT.read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
)
def test_every_package_is_in_it(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = source_digest()
    monkeypatch.setattr(module, "_COMPUTING", tuple(name for name in module._COMPUTING if name != package))
    module._digest.cache_clear()
    try:
        assert source_digest() != whole
    finally:
        module._digest.cache_clear()


def test_a_folder_besides_changes_it_by_what_is_in_it(tmp_path: Path) -> None:
    (tmp_path / "law.py").write_text("A = 1\n")
    before = source_digest(tmp_path)
    (tmp_path / "law.py").write_text("A = 2\n")
    module._digest.cache_clear()
    assert source_digest(tmp_path) != before
