"""What is raised where a motion tells no clock."""

from xneck_foundation.errors import Refused


class NoClue(Refused):
    """The motion does not tell the clock; a light may."""
