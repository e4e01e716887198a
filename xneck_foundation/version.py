"""The version of xneck that is installed."""

from importlib.metadata import version

VERSION = version("xneck")
