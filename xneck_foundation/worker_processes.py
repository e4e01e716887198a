"""Processes that share a work with this one, and end where it ends, however it does."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait


@contextmanager
def worker_processes(count: int) -> Iterator[Executor]:
    """A pool of fresh processes, which are ended where the work within is interrupted or fails.

    A fork of a process that has threads (OpenCV's, FFmpeg's) may hang, so that they are none. An interrupt of the keyboard goes to
    all processes of a terminal: they leave it to this one, which says one line.
    """
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), initializer=_end_with_parent)
    try:
        with _interrupts_ignored():
            # all of them begin with the first task, and take from this process what they ignore
            pool.submit(os.getpid)
        yield pool
    except BaseException:
        # they would finish what they are at, and this process wait for it
        for child in set(multiprocessing.active_children()) - before:
            child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


def _end_with_parent() -> None:
    """Ends this process as soon as the one that began it is no more: nobody would take what it does."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
