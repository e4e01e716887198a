"""Worker processes end with the one that began them: their standard output, which they share with it, comes to its end."""

import signal
import subprocess
import sys

import pytest

from xneck_foundation.worker_processes import worker_processes

AT_WORK_S = 120
SCRIPT = f"""
import time
from xneck_foundation.worker_processes import worker_processes
if __name__ == "__main__":
    with worker_processes(2) as pool:
        assert pool.submit(sum, [1, 2]).result() == 3
        print("at work", flush=True)
        list(pool.map(time.sleep, [{AT_WORK_S}, {AT_WORK_S}]))
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_their_parent(how: signal.Signals) -> None:
    """They stayed, of some hundred MB each; and an interrupt waited for what they were at."""
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "at work\n"
    process.send_signal(how)
    rest, _ = process.communicate(timeout=AT_WORK_S / 2)
    assert rest == ""
    assert process.returncode != 0


def test_work_comes_back_in_its_order() -> None:
    with worker_processes(2) as pool:
        assert list(pool.map(abs, range(-9, 0))) == list(range(9, 0, -1))
