"""Arguments of the functions for Python are of the kinds that their annotations say, else one line says which is not."""

import functools
import inspect
import os
from collections.abc import Callable, Sequence
from numbers import Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from xneck_foundation.errors import Refused
from xneck_foundation.one_line import shortened
from xneck_foundation.whole_file import BY_BLOCK, BY_OPTION

_READ_BY = {"DataSet": "read_dataset", "Neck": "read_neck", "Model": "read_model"}
"""what makes a thing of a file, by its class"""
_SHOWN = 40


def checked(function: Callable[..., Any], name: str) -> Callable[..., Any]:
    """The function, as `xneck.name`, which raises Refused where an argument is of another kind than it is annotated with.

    Its other refusals say what to do in Python, where there is no --force.
    """
    signature, kinds = inspect.signature(function), get_type_hints(function)

    @functools.wraps(function)
    def called(*values: Any, **options: Any) -> Any:
        for parameter, value in signature.bind(*values, **options).arguments.items():
            kind = kinds.get(parameter, Any)
            if not _is_of(value, kind):
                raise Refused(name, f"{parameter} is {_shown(value)}, expected {_words(kind)}", _advice(value, kind))
            if _is_list(kind) and not len(value) and signature.parameters[parameter].default is inspect.Parameter.empty:
                raise Refused(name, f"{parameter} is empty, expected {_words(kind)}", "give at least one")
        try:
            return function(*values, **options)
        except Refused as refusal:
            if BY_OPTION not in refusal.do:
                raise
            raise Refused(refusal.where, refusal.what, refusal.do.replace(BY_OPTION, BY_BLOCK)) from refusal

    called.__module__, called.__qualname__ = "xneck", name
    return called


def _is_of(value: Any, kind: Any) -> bool:
    """Whether a value is of a kind; also where a function looks itself, as at arrays and at one of several words."""
    if get_origin(kind) in (Union, UnionType):
        return any(_is_of(value, one) for one in get_args(kind))
    if _is_list(kind):
        return (
            isinstance(value, Sequence)
            and not isinstance(value, str)
            and all(_is_of(v, get_args(kind)[0]) for v in value)
        )
    if kind in (None, NoneType):
        return value is None
    if kind in (int, float):
        return isinstance(value, Real)
    if kind is Path:
        return isinstance(value, os.PathLike)
    if kind in (Any, bool) or not isinstance(kind, type) or get_origin(kind) or getattr(kind, "_is_protocol", False):
        return True
    return isinstance(value, kind)


def _is_list(kind: Any) -> bool:
    return get_origin(kind) is Sequence


def _words(kind: Any) -> str:
    """A kind for a person: `Neck`, `a list of DataSet`."""
    if _is_list(kind):
        return f"a list of {_words(get_args(kind)[0])}"
    if get_origin(kind) in (Union, UnionType):
        return " or ".join(_words(one) for one in get_args(kind))
    return "None" if kind in (None, NoneType) else getattr(kind, "__name__", str(kind))


def _shown(value: Any) -> str:
    """What was given: a short thing itself, else its class."""
    if value is None or isinstance(value, str | os.PathLike | Real):
        return shortened(repr(value), _SHOWN)
    if isinstance(value, Sequence) and value:
        return f"a list of {', '.join(dict.fromkeys(type(one).__name__ for one in value))}"
    return f"a {type(value).__name__}"


def _advice(value: Any, kind: Any) -> str:
    """What to do: read the file, or put the one thing into a list; empty where neither helps."""
    if _is_list(kind) and _is_of(value, get_args(kind)[0]):
        return "put it into a list: [...]"
    given = value[0] if isinstance(value, list | tuple) and value else value
    wanted = [_words(one) for one in get_args(kind)] or [_words(kind)]
    reader = next((_READ_BY[word] for word in wanted if word in _READ_BY), None)
    return f"read it first: xneck.{reader}(...)" if reader and isinstance(given, str | os.PathLike) else ""
