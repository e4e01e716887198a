"""The bytes of a file that another program is writing: read only, without locks, in the order in which they come."""

from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from xneck_foundation.errors import Refused


class GrowingFile:
    """A file that is read as it grows; a reader that wants more than there is waits."""

    def __init__(self, path: Path, wait: Callable[[], bool] = lambda: False) -> None:
        """wait: is called where all was read; False ends the file, after True more is looked for."""
        self.path = path
        self._wait = wait
        self._stream: BinaryIO | None = None
        self.position = 0
        """bytes that were read"""

    @property
    def size(self) -> int:
        """Bytes that the file has now; 0 where it is not there yet."""
        try:
            return self.path.stat().st_size
        except FileNotFoundError:
            return 0

    def read_available(self, size: int) -> bytes:
        """At most `size` of the next bytes, none where none are there yet. Raises Refused where the file became shorter."""
        if self._stream is None:
            if not self.path.is_file():
                return b""
            self._stream = self.path.open("rb", buffering=0)
        if self.size < self.position:
            raise Refused(self.path, "was cut or replaced while it was watched", "watch it anew")
        data = self._stream.read(size)
        self.position += len(data)
        return data

    def read(self, size: int) -> bytes:
        """At most `size` of the next bytes, as soon as there are any; none where the file has ended."""
        try:
            while True:
                if data := self.read_available(size):
                    return data
                if not self._wait():
                    return b""
        except KeyboardInterrupt:  # FFmpeg, which called, passes on no interrupt: for it the file ends here
            return b""

    def close(self) -> None:
        """Lets go of the file."""
        if self._stream is not None:
            self._stream.close()
