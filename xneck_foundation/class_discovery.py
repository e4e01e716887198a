"""Classes found in the modules of a package: whoever adds a module has added its class."""

import importlib
import pkgutil
from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def classes_in(package: str, path: Iterable[str], base: type[T]) -> list[type[T]]:
    """Classes derived from `base` that modules of a package define, by the modules' names; path: the package's `__path__`."""
    names = sorted(module.name for module in pkgutil.iter_modules(path, f"{package}."))
    return [
        value
        for name in names
        for value in vars(importlib.import_module(name)).values()
        if isinstance(value, type) and issubclass(value, base) and value.__module__ == name and value is not base
    ]
