"""The commit that is tested: what differs from one to the next is drawn from it."""

import subprocess
from functools import cache

NO_REPOSITORY = "0" * 40


@cache
def commit() -> str:
    """Its 40 hexadecimal digits; zeros where there is no repository."""
    try:
        return subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return NO_REPOSITORY
