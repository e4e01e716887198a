"""Module constants set to another value for a while, also where other modules have imported them by name."""

import ast
import importlib
import inspect
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import ModuleType
from typing import Any


@contextmanager
def patched(module: str, name: str, value: Any) -> Iterator[None]:
    """`module.name` is `value` inside the block, in every loaded module that holds it."""
    places = [(importlib.import_module(module), name), *_importers(module, name)]
    before = [(holder, alias, getattr(holder, alias)) for holder, alias in places]
    for holder, alias in places:
        setattr(holder, alias, value)
    try:
        yield
    finally:
        for holder, alias, old in before:
            setattr(holder, alias, old)


def _importers(module: str, name: str) -> list[tuple[ModuleType, str]]:
    """Loaded modules of this project that import the constant by name, and what they call it."""
    return [
        (holder, alias)
        for holder in list(sys.modules.values())
        if getattr(holder, "__name__", "").split(".")[0] == module.split(".")[0] or _is_ours(holder)
        for alias in _aliases(holder, module, name)
    ]


def _is_ours(module: ModuleType) -> bool:
    file = getattr(module, "__file__", None) or ""
    return bool(file) and "site-packages" not in file and "/lib/python" not in file


def _aliases(holder: ModuleType, module: str, name: str) -> list[str]:
    return [alias for source, original, alias in _imports(holder) if (source, original) == (module, name)]


@cache
def _imports(holder: ModuleType) -> tuple[tuple[str, str, str], ...]:
    """(module, name, alias) of every `from module import name as alias` at the top of a module."""
    try:
        tree = ast.parse(inspect.getsource(holder))
    except (OSError, TypeError):
        return ()
    return tuple(
        (node.module or "", alias.name, alias.asname or alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    )
