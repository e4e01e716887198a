"""An arm's markers, all of which are in a dictionary that is known."""

from pathlib import Path

from calibration.dictionaries import dictionary_names, dictionary_size
from mechanism.description import Neck, markers_of
from mechanism.printed_markers import Markers
from xneck_foundation.errors import Refused, one_of


def known_markers(neck: Neck, where: str | Path) -> Markers:
    """The markers of the arm that `where` describes.

    Raises Refused with the key's path where it has none, their dictionary is not known, or has no marker of an id.
    """
    markers = markers_of(neck, where)
    name = one_of(f"{where}: markers.dictionary", markers.dictionary, dictionary_names(), "dictionary")
    size = dictionary_size(name)
    for k, marker in enumerate(markers.on_bars):
        if marker.id >= size:
            raise Refused(where, f"markers.on_bars[{k}].id is {marker.id}, but {name} has the ids 0 to {size - 1}")
    return markers
