"""What all parts of xneck stand on: errors, strict files, whole outputs, estimates."""

from importlib.metadata import version

__version__ = version("xneck")
