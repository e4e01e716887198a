"""The scheduling of this process kept as it was, whatever a library does to it.

As root SVT-AV1 puts the thread that opens it, and all that follow, among those that run before everything else on the machine:
a process that goes on so starves its neighbours, and what it starts inherits it.
"""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path


def keeping_usual_priority(action: Callable[[], None]) -> None:
    """Do something; then every thread of this process is scheduled as the calling one was before."""
    if not hasattr(os, "sched_setscheduler"):  # not on macOS and Windows, where the encoder leaves priorities alone
        action()
        return
    policy, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        action()
    finally:
        for thread in Path("/proc/self/task").iterdir():
            with suppress(ProcessLookupError, PermissionError):  # it ended meanwhile
                os.sched_setscheduler(int(thread.name), policy, parameters)
