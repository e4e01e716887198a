"""One run at a time in a folder of results."""

import contextlib
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import lock_file

LOCK_FILE = ".xneck.lock"


@contextmanager
def only_run_in(folder: Path) -> Iterator[None]:
    """Makes `folder` and holds it for this process until the block ends, or the process does, however it ends.

    A folder that is made here and stays empty is removed again. Raises Refused where another run holds it, or it cannot be made.
    """
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = _held(folder)
    except OSError as error:
        raise Refused(folder, f"cannot be written to ({error.strerror})", "name another folder") from error
    try:
        yield
    finally:
        (folder / LOCK_FILE).unlink(missing_ok=True)
        os.close(handle)
        if made:
            with contextlib.suppress(OSError):  # results are in it
                folder.rmdir()


def _held(folder: Path) -> int:
    """The handle of the folder's lock file, locked."""
    path = folder / LOCK_FILE
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        if lock_file(handle) is False:
            holder = os.read(handle, 200).decode(errors="replace").strip()
            os.close(handle)
            raise Refused(folder, f"another run is at work in it ({holder})", "wait for it, or name another folder")
        with contextlib.suppress(FileNotFoundError):
            if os.stat(path).st_ino == os.fstat(handle).st_ino:  # else its holder has just removed it
                os.ftruncate(handle, 0)
                os.write(handle, f"process {os.getpid()} on {socket.gethostname()}\n".encode())
                return handle
        os.close(handle)
