"""The faults of a document that is not of its kind, in words: each with its key's path, and none that only follows from another."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel

from xneck_foundation.one_line import counted, listed, shortened
from xneck_foundation.spelling import likely_spelling, valid_words
from xneck_foundation.value_hints import likely_meant, limit_text

_FAULT_CHARACTERS = 280
"""characters of all faults of a document before the rest is counted"""
_SHOWN = 60
"""characters of a value that is not what it should be"""

_COMPARED = 50
"""unknown keys that are compared with those that are missing: no more are shown"""

_PLAIN_WORDS = {"model_type": "expected keys and values", "bool_type": "expected true or false"}
"""by pydantic's kinds of errors"""

Path = tuple[str | int, ...]


def described_faults(errors: Sequence[Any], kind: type[BaseModel], document: Any, written: bool = True) -> str:
    """pydantic's errors of a `document` that is no `kind`, in words, those that lead to others alone.

    written: whether a person wrote all of it, and not a single key more, which then was meant to be one that is there.
    """
    meant = _meant(errors, kind, document)
    followed = {(*path[:-1], word) for path, word in meant.items()}
    # entries that are at fault are not counted, so that their list is said to be too short besides
    above = {error["loc"][:depth] for error in errors for depth in range(len(error["loc"]))}
    follows = {"missing": followed, "too_short": above}
    faults = [e for e in errors if e["loc"] not in follows.get(e["type"], ())]
    doubled = _doubled(errors, kind, document, meant)
    if not written:
        meant, doubled = meant | doubled, {}
    return listed(_said_once(faults, [_fault(e, meant, doubled, kind) for e in faults]), "; ", _FAULT_CHARACTERS)


def _said_once(errors: Sequence[Any], faults: Sequence[str]) -> Iterator[str]:
    """The faults in words; one that several entries of a list have is said of the first, with how many others have it."""
    alike: dict[tuple[Any, ...], list[str]] = {}
    for error, fault in zip(errors, faults, strict=True):
        way = tuple("[]" if isinstance(part, int) else part for part in error["loc"])
        alike.setdefault((way, fault.partition(": ")[2] if error["loc"] else fault), []).append(fault)
    for first, *others in alike.values():
        yield first + (f" (and in {counted(len(others), 'other')})" if others else "")


def _meant(errors: Sequence[Any], kind: type[BaseModel], document: Any) -> dict[Path, str]:
    """For each unknown key, by its path, the key that was likely meant, of those that are not there."""
    found: dict[Path, str] = {}
    taken: set[Path] = set()
    unknown = [e["loc"] for e in errors if e["type"] == "extra_forbidden"]
    for *place, key in unknown[:_COMPARED]:
        given = _at(document, place)
        if likely_spelling(str(key), _keys(kind, place)) in given:
            continue
        absent = [name for name in _keys(kind, place) if name not in given and (*place, name) not in taken]
        likely = likely_spelling(str(key), absent)
        if likely is not None:
            found[*place, key] = likely
            taken.add((*place, likely))
    return found


def _doubled(errors: Sequence[Any], kind: type[BaseModel], document: Any, meant: Mapping[Path, str]) -> dict[Path, str]:
    """For each other unknown key, by its path, the key that it is likely another spelling of, of those that are there."""
    found: dict[Path, str] = {}
    unknown = [e["loc"] for e in errors if e["type"] == "extra_forbidden" and e["loc"] not in meant]
    for *place, key in unknown[:_COMPARED]:
        given = _at(document, place)
        likely = likely_spelling(str(key), [name for name in _keys(kind, place) if name in given])
        if likely is not None:
            found[*place, key] = likely
    return found


def _at(document: Any, place: Sequence[str | int]) -> Any:
    """The part of a document at a path."""
    for part in place:
        document = document[part]
    return document


def _keys(kind: type[BaseModel], place: Sequence[str | int]) -> list[str]:
    """Names of the keys that may stand at a path of a document."""
    return list(_model_at(kind, place).model_fields)


def _model_at(kind: type[BaseModel], place: Sequence[str | int]) -> type[BaseModel]:
    """The model of what stands at a path of a document."""
    for part in place:
        if isinstance(part, str):
            kind = next(_models(kind.model_fields[part].annotation))
    return kind


def _belongs(kind: type[BaseModel], loc: Sequence[str | int]) -> str | None:
    """Where an unknown key at a path may stand, if there is one place of least depth: below where it is, or in the document."""
    *above, key = loc
    inside = "".join("[]" if isinstance(part, int) else f".{part}" for part in above).removeprefix(".")
    for model, start in ((_model_at(kind, above), f"{inside}." if inside else ""), (kind, "")):
        places = sorted(_places(model, key, start), key=lambda place: place.count("."))
        if places and (len(places) == 1 or places[0].count(".") < places[1].count(".")):
            return places[0]
    return None


def _places(kind: type[BaseModel], key: str | int, above: str = "") -> list[str]:
    """Where in a document a key of that name may stand, such as `mechanisms[].springs`."""
    found = []
    for name, field in kind.model_fields.items():
        for model in _models(field.annotation):
            listed_there = "tuple" in str(field.annotation).split(model.__name__)[0]
            place = f"{above}{name}{'[]' * listed_there}"
            found += [place] if key in model.model_fields else []
            found += _places(model, key, f"{place}.")
    return found


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models in an annotation such as tuple[Cable, ...] | None."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models(argument)


def _unit(kind: type[BaseModel], place: Sequence[str | int]) -> str:
    """The unit of the number at a path, with which the description of its key begins; something else where there is none."""
    while place and isinstance(place[-1], int):
        place = place[:-1]
    field = _model_at(kind, place[:-1]).model_fields.get(str(place[-1])) if place else None
    return ((field.description if field else None) or "").partition(",")[0]


def _fault(error: Any, meant: Mapping[Path, str], doubled: Mapping[Path, str], kind: type[BaseModel]) -> str:
    place = ""
    for part in error["loc"]:
        shown = part if isinstance(part, int) else shortened(part, _SHOWN)
        place += f"[{shown}]" if isinstance(part, int) else (f".{shown}" if place else str(shown))
    place = place or "the file as a whole"
    context = error.get("ctx", {})
    if error["type"] == "missing":
        return f"{place}: missing"
    if error["type"] == "extra_forbidden":
        if error["loc"] in meant:
            return f"{place}: unknown key, did you mean {meant[error['loc']]}?"
        if error["loc"] in doubled:
            return f"{place}: unknown key, {doubled[error['loc']]} is there already, leave one out"
        if elsewhere := _belongs(kind, error["loc"]):
            return f"{place}: unknown key here, it belongs to {elsewhere}"
        return f"{place}: unknown key, valid: {listed(_keys(kind, error['loc'][:-1]), limit=_SHOWN)}"
    message = error["msg"].removeprefix("Value error, ")
    message = message.replace("Input should be", "expected")
    if message[1:2].islower():  # a sentence; L and b stay as they are
        message = message[0].lower() + message[1:]
    if not error["loc"] and re.split(r"\W", message, maxsplit=1)[0] in kind.model_fields:
        return message  # it says its place by itself
    if error["type"] in _PLAIN_WORDS:
        message = _PLAIN_WORDS[error["type"]]
    for limit in (context[key] for key in ("le", "lt", "ge", "gt") if key in context):
        message = f"{message.rpartition(' ')[0]} {limit_text(limit)}"
    meant_value = ""
    if not isinstance(error["input"], str) or error["type"].startswith(("float", "int")):  # text may be meant as text
        meant_value = likely_meant(error["input"], _unit(kind, error["loc"]), context)
    if error["type"] == "too_short":
        return f"{place}: expected at least {context['min_length']}, found {context['actual_length']}"
    if error["type"] == "too_long" and isinstance(error["input"], list | tuple):
        return f"{place}: expected at most {context['max_length']}, found {len(error['input'])}{meant_value}"
    found = error["input"]
    if found is None:
        return f"{place}: {message}, found nothing"
    if isinstance(found, BaseModel) or (error["type"] == "value_error" and isinstance(found, dict | list)):
        return f"{place}: {message}"
    if isinstance(found, dict | list):
        return f"{place}: {message}" + (", found keys and values" if isinstance(found, dict) else ", found a list")
    hint = meant_value
    if error["type"] == "literal_error" and isinstance(found, str):
        words = re.findall(r"'([^']*)'", context["expected"])
        hint = f", {valid_words(found, words)}" if likely_spelling(found, words) else ""
    return f"{place}: {message}, found {shortened(repr(found), _SHOWN)}{hint}"
