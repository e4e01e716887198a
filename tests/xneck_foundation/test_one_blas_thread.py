"""Linear algebra ends in the same digits whatever the number of cores and threads."""

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from threadpoolctl import threadpool_info, threadpool_limits

from tests.paths import ROOT
from xneck_foundation.one_blas_thread import one_blas_thread

JOB = """
import hashlib, numpy as np, scipy.linalg
from xneck_foundation.one_blas_thread import one_blas_thread

@one_blas_thread
def job():
    A = np.random.default_rng(0).normal(size=(700, 700))
    return A @ A.T, scipy.linalg.qr(A)[1], np.linalg.lstsq(A, A[:, 0], rcond=None)[0]

print(hashlib.sha256(b"".join(part.tobytes() for part in job())).hexdigest())
"""


def threads() -> set[int]:
    """Of the BLAS libraries of numpy and scipy."""
    assert scipy.linalg.norm(np.ones(2)) > 0
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


@pytest.fixture
def three_threads() -> Any:
    with threadpool_limits(limits=3, user_api="blas"):
        if threads() != {3}:
            pytest.skip("BLAS has no three threads here")
        yield


def test_the_bytes_do_not_depend_on_the_threads_that_are_asked_for() -> None:
    said = set()
    for count in ("1", "2", "4"):
        settings = {"OPENBLAS_NUM_THREADS": count, "OMP_NUM_THREADS": count, "PYTHONHASHSEED": count}
        call = [sys.executable, "-c", JOB]
        done = subprocess.run(call, capture_output=True, text=True, env=os.environ | settings, cwd=ROOT, check=True)
        said.add(done.stdout)
    assert len(said) == 1


def test_threads_are_given_back(three_threads: None) -> None:
    inside = one_blas_thread(threads)
    assert (inside(), threads()) == ({1}, {3})
    with pytest.raises(ZeroDivisionError):
        one_blas_thread(lambda: 1 / 0)()
    assert threads() == {3}


TWO_THREADS = """
import threading
from tests.xneck_foundation.test_one_blas_thread import threads
from xneck_foundation.one_blas_thread import one_blas_thread

entered, found = threading.Event(), []

@one_blas_thread
def second():
    entered.set()
    found.append(threads())

@one_blas_thread
def first():
    waiting.start()
    found.append("waits" if not entered.wait(0.3) else "does not wait")
    found.append(threads())

before = threads()
waiting = threading.Thread(target=second)
first()
waiting.join()
print(found == ["waits", {1}, {1}], threads() == before)
"""


def test_of_two_threads_one_waits() -> None:
    """Who returns first would give the other its threads back. In a process in which nobody else limits them."""
    settings = {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"}
    call = [sys.executable, "-c", TWO_THREADS]
    done = subprocess.run(call, capture_output=True, text=True, env=os.environ | settings, cwd=ROOT, check=True)
    assert done.stdout == "True True\n"


def test_a_function_inside_another_leaves_them_at_one(three_threads: None) -> None:
    @one_blas_thread
    def outer(inner: Callable[[], set[int]]) -> tuple[set[int], set[int]]:
        return inner(), threads()

    assert outer(one_blas_thread(threads)) == ({1}, {1})
    assert threads() == {3}
