"""What a benchmark ran on: figures of time hold for that alone."""

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from xneck_foundation.provenance import versions

PEERS = ("mujoco", "pyapriltags")


def machine() -> dict[str, Any]:
    """Processor, cores, system, and versions of Python, of the libraries and of the peers. Ready for JSON."""
    made_with = versions()
    libraries = made_with["libraries"] | {name: _version(name) for name in PEERS}
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        **made_with,
        "libraries": libraries,
    }


def commit() -> str | None:
    """Of the checkout, `+` behind it where files differ; None without git."""
    call = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty=+"]
    try:
        return subprocess.run(call, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def _processor() -> str:
    """As the kernel names it, or as Python does."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
