"""A module that is put into a package adds its classes, and only those that it defines."""

import importlib
from pathlib import Path

import pytest

from xneck_foundation.class_discovery import classes_in


@pytest.mark.parametrize("modules", [("apple",), ("banana", "apple")])
def test_classes_are_found_by_module_and_counted_once(
    modules: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"basket_of_{len(modules)}"
    folder = tmp_path / name
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "fruit.py").write_text("class Fruit: ...\n")
    for module in modules:
        first = f"from {name}.fruit import Fruit\nclass {module.title()}(Fruit): ...\n"
        (folder / f"{module}.py").write_text(first + f"class Dried{module.title()}({module.title()}): ...\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    package = importlib.import_module(name)
    base = importlib.import_module(f"{name}.fruit").Fruit
    found = [found.__name__ for found in classes_in(name, package.__path__, base)]
    assert found == [c for module in sorted(modules) for c in (module.title(), f"Dried{module.title()}")]
