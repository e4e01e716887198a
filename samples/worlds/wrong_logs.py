"""Logs and angles that mean something else than their columns say, or that are unusual: for tests, and for docs/logs.md.

Each is made from one recording without fault by one change.
"""

from samples.worlds.wrong_log import WrongLog
from samples.worlds.wrong_log_files import WRONG_FILES
from samples.worlds.wrong_log_values import WRONG_VALUES

WRONG_LOGS: tuple[WrongLog, ...] = (*WRONG_VALUES, *WRONG_FILES)
"""every one of them, in the order of docs/logs.md"""
