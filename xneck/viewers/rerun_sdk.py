"""Rerun's library, an extra that only `--rerun` needs: it is larger than all others together."""

import importlib
from pathlib import Path
from typing import Any

from xneck_foundation.errors import Refused


def rerun_sdk(where: str | Path) -> Any:
    """The module `rerun`. Raises Refused where the extra is not installed."""
    try:
        return importlib.import_module("rerun")
    except ImportError as error:
        raise Refused(where, f"needs rerun-sdk ({error})", "pip install 'xneck[rerun]'") from error
