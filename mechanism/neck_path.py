"""Numbers of a description by their paths in neck.yaml, such as `mechanisms[0].top.mass`."""

from typing import Any

from xneck_foundation.errors import Refused


def set_at(tree: dict[str, Any], path: str, value: Any) -> None:
    """Sets what a path leads to in maps and lists; the path of a list without a number is that of all its entries.

    A key that is not there is made: whoever reads the tree knows which there may be. Raises Refused where a path leads nowhere.
    """
    try:
        _set(tree, path, value)
    except (AttributeError, IndexError, TypeError, ValueError) as error:
        raise Refused(
            "neck", f"has no {path}", "a path as in neck.yaml: mechanisms[0].L, or mechanisms.L of all"
        ) from error


def _set(tree: Any, path: str, value: Any) -> None:
    key, _, rest = path.partition(".")
    name, _, number = key.partition("[")
    if not rest and not number:
        tree[name] = value
        return
    part = tree.setdefault(name, {})
    if not isinstance(part, list | tuple):
        _set(part, rest, value)
        return
    entries = tree[name] = list(part)
    for k in [int(number.removesuffix("]"))] if number else range(len(entries)):
        if rest:
            _set(entries[k], rest, value)
        else:
            entries[k] = value
