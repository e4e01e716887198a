"""The mark by which xneck knows a file that it wrote, so that it never replaces one that somebody else wrote or changed.

The mark is in the file, not beside it: it goes along when a folder is copied. Text carries the SHA-256 of what xneck wrote, so
that a file edited by hand is the person's. Where a format has no place for comments, the mark stands where every reader of
the format passes over it: as a last key of JSON, as digits of a CSV's last time that are beyond the precision of a double, as
the comment of a zip archive, and in what binary files say of themselves.
"""

import hashlib
import re
import zipfile
from collections.abc import Callable
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import BinaryIO

MARK = "written by xneck"
"""text in the metadata of binary files"""

JSON_KEY = "written_by"
"""the key of JSON files that holds the mark, the last one"""

_COMMENTS = {
    **dict.fromkeys((".yaml", ".yml"), ("# ", "")),
    **dict.fromkeys((".html", ".svg", ".xml", ".md"), ("<!-- ", " -->")),
    ".pdf": ("% ", ""),
    ".c": ("/* ", " */"),
}
"""what begins and ends a comment on a line of its own, by suffix"""
_TEXT = re.compile(r"xneck wrote what stands above, sha256 ([0-9a-f]{64})")
_JSON_END = re.compile(rb'(,?)\s*"' + JSON_KEY.encode() + rb'": "xneck, sha256 ([0-9a-f]{64})"\s*\}\s*$')
_CSV_DECIMALS, _CSV_DIGITS = 30, 18
"""decimals of the marked time, of which a double holds at most 17 figures, and digits of the mark that follow them"""
_SEARCHED_BYTES = 1 << 16
"""bytes at each end of a binary file in which its metadata is looked for"""
_LONGEST_LINE_BYTES = 1 << 20


def sign(path: Path, suffix: str) -> None:
    """Marks a complete file of the kind that `suffix` names as xneck's; binary files of other kinds hold MARK as they are."""
    kind = _kind(path, suffix)
    if kind in _COMMENTS:
        _sign_comment(path, *_COMMENTS[kind])
    elif kind in _SIGNERS:
        _SIGNERS[kind](path)


def written_by_xneck(path: Path) -> bool:
    """Whether xneck wrote the file as it is now. False too where it cannot be read."""
    try:
        kind = _kind(path, path.suffix)
        if kind in _COMMENTS:
            return _has_comment(path, *_COMMENTS[kind])
        return _READERS.get(kind, _has_mark)(path)
    except (OSError, zipfile.BadZipFile):
        return False


def yaml_kind(path: Path) -> str:
    """What a YAML file is, by its key of a format such as `xneck_model`, else by its first key; empty where it has none."""
    with path.open("rb") as stream:
        head = stream.read(_SEARCHED_BYTES).decode(errors="replace")
    keys = re.findall(r"^([A-Za-z_]\w*):", head, re.MULTILINE)
    return next((key for key in keys if re.fullmatch(r"xneck(_\w+)?", key)), keys[0] if keys else "")


def _kind(path: Path, suffix: str) -> str:
    """The suffix that tells the format; .json where the name has none and the content begins as JSON does."""
    if suffix:
        return suffix.lower()
    with path.open("rb") as stream:
        return ".json" if stream.read(1) == b"{" else ""


def _digest(stream: BinaryIO, size: int) -> "hashlib._Hash":
    """SHA-256 of the first `size` bytes, read in blocks."""
    digest = hashlib.sha256()
    stream.seek(0)
    while size > 0 and (block := stream.read(min(size, 1 << 20))):
        digest.update(block)
        size -= len(block)
    return digest


def _tail(stream: BinaryIO, size: int) -> tuple[int, bytes]:
    """The last bytes of a file and where they begin."""
    at = max(0, stream.seek(0, 2) - size)
    stream.seek(at)
    return at, stream.read()


def _sign_comment(path: Path, begin: str, end: str) -> None:
    with path.open("r+b") as stream:
        _, last = _tail(stream, 1)
        if last not in (b"\n", b""):
            stream.write(b"\n")
        digest = _digest(stream, stream.seek(0, 2)).hexdigest()
        stream.seek(0, 2)
        stream.write(f"{begin}xneck wrote what stands above, sha256 {digest}{end}\n".encode())


def _has_comment(path: Path, begin: str, end: str) -> bool:
    with path.open("rb") as stream:
        at, tail = _tail(stream, 200)
        line = tail.rstrip(b"\n").rfind(b"\n") + 1
        text = tail[line:].decode(errors="replace").strip()
        found = _TEXT.fullmatch(text.removeprefix(begin).removesuffix(end))
        return found is not None and _digest(stream, at + line).hexdigest() == found[1]


def _sign_json(path: Path) -> None:
    with path.open("r+b") as stream:
        at, tail = _tail(stream, _SEARCHED_BYTES)
        content = tail.rstrip()
        if not content.endswith(b"}"):
            return  # a bare list or number has no place for a mark
        content = content[:-1].rstrip()
        size = at + len(content)
        digest = _digest(stream, size).hexdigest()
        stream.seek(size)
        comma = b"" if content.endswith(b"{") else b","
        stream.write(comma + f'\n  "{JSON_KEY}": "xneck, sha256 {digest}"\n}}\n'.encode())
        stream.truncate()


def _is_signed_json(path: Path) -> bool:
    with path.open("rb") as stream:
        at, tail = _tail(stream, 400)
        found = _JSON_END.search(tail)
        return found is not None and _digest(stream, at + found.start()).hexdigest() == found[2].decode()


def _last_cell(stream: BinaryIO) -> tuple[int, int, str]:
    """Where the first cell of a CSV's last row begins and ends, and its text."""
    at, tail = _tail(stream, _LONGEST_LINE_BYTES)
    begin = tail.rstrip(b"\r\n").rfind(b"\n") + 1
    cell = re.match(rb"[^,\r\n]*", tail[begin:])
    assert cell is not None  # the pattern matches an empty text too
    return at + begin, at + begin + cell.end(), cell[0].decode(errors="replace")


def _csv_mark(stream: BinaryIO, begin: int, end: int, value: float) -> str:
    """Digits that follow from all of a CSV: what precedes the marked cell, its value, and what follows it."""
    digest = _digest(stream, begin)
    digest.update(repr(value).encode())
    stream.seek(end)
    digest.update(stream.read())
    return str(int.from_bytes(digest.digest()[:16], "big") % 10**_CSV_DIGITS).zfill(_CSV_DIGITS)


def _sign_csv(path: Path) -> None:
    with path.open("r+b") as stream:
        begin, end, cell = _last_cell(stream)
        try:
            value, padded = float(cell), f"{Decimal(cell):.{_CSV_DECIMALS}f}"
        except (ValueError, InvalidOperation):
            return  # a header alone
        marked = padded + _csv_mark(stream, begin, end, value)
        if float(marked) != value:
            return
        stream.seek(end)
        rest = stream.read()
        stream.seek(begin)
        stream.write(marked.encode() + rest)


def _is_signed_csv(path: Path) -> bool:
    with path.open("rb") as stream:
        begin, end, cell = _last_cell(stream)
        found = re.fullmatch(rf"-?[0-9]+\.[0-9]{{{_CSV_DECIMALS}}}([0-9]{{{_CSV_DIGITS}}})", cell)
        return found is not None and found[1] == _csv_mark(stream, begin, end, float(cell))


def _sign_zip(path: Path) -> None:
    with zipfile.ZipFile(path, "a") as archive:
        archive.comment = MARK.encode()


def _is_signed_zip(path: Path) -> bool:
    with zipfile.ZipFile(path) as archive:
        return archive.comment == MARK.encode()


def _is_xneck_mcap(path: Path) -> bool:
    """The header names the library that wrote the file (MCAP specification, opcode 1)."""
    with path.open("rb") as stream:
        return re.match(rb"\x89MCAP0\r\n\x01.{8}.{4}ros2.{4}xneck [0-9]", stream.read(64), re.DOTALL) is not None


def _is_xneck_rrd(path: Path) -> bool:
    """Rerun's first message names the application, as plain text."""
    with path.open("rb") as stream:
        head = stream.read(512)
        return head.startswith(b"RRF") and b"xneck" in head


def _has_mark(path: Path) -> bool:
    with path.open("rb") as stream:
        return MARK.encode() in stream.read(_SEARCHED_BYTES) or MARK.encode() in _tail(stream, _SEARCHED_BYTES)[1]


_SIGNERS: dict[str, Callable[[Path], None]] = {
    ".json": _sign_json,
    ".csv": _sign_csv,
    ".npz": _sign_zip,
    ".zip": _sign_zip,
}
_READERS: dict[str, Callable[[Path], bool]] = {
    ".json": _is_signed_json,
    ".csv": _is_signed_csv,
    ".npz": _is_signed_zip,
    ".zip": _is_signed_zip,
    ".mcap": _is_xneck_mcap,
    ".rrd": _is_xneck_rrd,
}
