"""What kind of file it is by its first bytes, whatever its name says."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input


@dataclass(frozen=True)
class FileKind:
    """A kind of file that is no text in UTF-8."""

    begins: bytes
    name: str
    suffix: str = ""
    """that such files have; empty where nothing here reads them under any name"""
    do: str = "export it as CSV"
    """where it cannot be read, whatever its name"""
    at: int = 0
    """byte at which `begins` stands"""

    @property
    def is_text(self) -> bool:
        """Whether it is text in another encoding."""
        return self.name.startswith("text")


_INSTEAD_OF_VIDEO = "give a table or an MCAP here; `xneck extract` makes angles of a video"

_UTF_16 = FileKind(b"\xff\xfe", "text in UTF-16", do="save it as UTF-8")
_KINDS = (
    FileKind(b"\x89MCAP0\r\n", "an MCAP file", ".mcap"),
    FileKind(b"PAR1", "a Parquet file", ".parquet"),
    FileKind(b"#ROSBAG", "a ROS bag", ".bag"),
    FileKind(b"SQLite format 3\0", "an SQLite file, as bags of ROS 2 are", ".db3"),
    FileKind(b"ARROW1", "an Arrow (Feather) file"),
    FileKind(b"\x89HDF\r\n\x1a\n", "an HDF5 file, as MATLAB's newer .mat are"),
    FileKind(b"TDSm", "a TDMS file, as LabVIEW writes them"),
    FileKind(b"MATLAB 5.0 MAT-file", "a MATLAB file"),
    FileKind(b"\x93NUMPY", "a NumPy file"),
    FileKind(b"PK\x03\x04", "a ZIP archive, as .xlsx and .npz are"),
    FileKind(b"\x1f\x8b", "packed by gzip", do="unpack it first"),
    FileKind(b"\x28\xb5\x2f\xfd", "packed by zstd", do="unpack it first"),
    FileKind(b"\xfd7zXZ", "packed by xz", do="unpack it first"),
    FileKind(b"BZh", "packed by bzip2", do="unpack it first"),
    FileKind(b"ftyp", "a video", do=_INSTEAD_OF_VIDEO, at=4),
    FileKind(b"\x1a\x45\xdf\xa3", "a video", do=_INSTEAD_OF_VIDEO),
    FileKind(b"AVI LIST", "a video", do=_INSTEAD_OF_VIDEO, at=8),
    _UTF_16,
    replace(_UTF_16, begins=b"\xfe\xff"),
)


def refuse_other_kind(path: Path, readable: Sequence[str]) -> None:
    """Raises Refused where a file that is to be read as CSV is of another kind; readable: suffixes that are read there."""
    check_input(path)
    kind = known_kind(path)
    if kind is not None:
        do = f"let its name end in {kind.suffix}" if kind.suffix and kind.suffix in readable else kind.do
        raise Refused(path, f"is no CSV but {kind.name}", do)


def known_kind(path: Path) -> FileKind | None:
    """What a file is that is no text in UTF-8; None where it may be one. Raises Refused where it cannot be read."""
    try:
        with path.open("rb") as stream:
            head = stream.read(32)
    except OSError as error:
        raise Refused(path, f"cannot be read ({error.strerror or error})") from error
    known = next((kind for kind in _KINDS if head.startswith(kind.begins, kind.at)), None)
    # letters of Western languages have a zero beside each in UTF-16
    is_utf_16 = len(head) > 1 and any(head[0::2]) != any(head[1::2])
    return known or (_UTF_16 if is_utf_16 else None)
