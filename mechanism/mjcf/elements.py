"""XML elements with attributes that are numbers, texts or rows of numbers."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

Attribute = str | float | int | bool | Iterable[float]


def child(parent: Element, tag: str, **attributes: Attribute) -> Element:
    """A new element in `parent`; numbers are written so that they are read back as they are. `class_` becomes class."""
    return SubElement(parent, tag, {key.rstrip("_"): text_of(value) for key, value in attributes.items()})


def text_of(value: Attribute) -> str:
    """An attribute's value as MJCF has it."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(float(value)) if not isinstance(value, int) else str(value)
    return " ".join(text_of(float(number)) for number in value)
