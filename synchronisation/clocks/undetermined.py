"""The refusal of a motion that does not determine the clock."""

from xneck_foundation.errors import Refused


class ClockUndetermined(Refused):
    """The motion does not determine the clock; a light that the controller switches still may."""
