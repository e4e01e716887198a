"""What a picture file says of itself before it is decoded: its format, its size, and what OpenCV would pass over.

OpenCV goes by the content, not by the name, and takes the first of several pictures without a word. The formats that are read are
listed here, so that a file is what its name says, or refused for what it is.
"""

import re
import struct
from dataclasses import dataclass

_SUBFILE, _WIDTH, _HEIGHT, _ORIENTATION = 254, 256, 257, 274
"""tags of a TIFF"""
_NOT_READ = (
    (rb"GIF8", "a GIF"),
    (rb"....ftyp(avif|avis|hei|mif1)|....JXL |\xff\x0a", "an AVIF, HEIF or JPEG XL picture"),
    (rb"....jP  |\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    (rb"#\?RADIANCE|P[Ff]\s|v/1\x01", "a picture of floating-point brightness"),
    (rb"....(ftyp|moov|mdat)|\x1aE\xdf\xa3|RIFF....AVI ", "a video"),
    (rb"\s*(<\?xml|<svg|#EXTM3U|ffconcat)", "a text"),
)


@dataclass(frozen=True)
class PictureHeader:
    """A picture of a format that is read."""

    width: int
    height: int
    several: bool = False
    """whether more pictures follow, as in an animation"""
    turned: bool = False
    """whether a tag turns it that OpenCV obeys though it is told not to"""


def read_header(content: bytes) -> PictureHeader | str:
    """The header of a picture, or in words what the content is instead ("a GIF"). Raises ValueError where the header is damaged."""
    if not content:
        return "an empty file"
    try:
        for magic, read in _READERS:
            if re.match(magic, content, re.DOTALL):
                return read(content)
    except struct.error as error:
        raise ValueError(str(error)) from error
    for magic, words in _NOT_READ:
        if re.match(magic, content, re.DOTALL):
            return words
    return "no picture of these formats"


def _png(content: bytes) -> PictureHeader:
    width, height = struct.unpack_from(">II", content, 16)
    animation = content.find(b"acTL")
    return PictureHeader(width, height, several=0 <= animation < content.find(b"IDAT"))


def _jpeg(content: bytes) -> PictureHeader:
    """The size stands in the start of frame: marker C0 to CF, but for tables (C4, C8, CC)."""
    at = 2
    while True:
        marker, length = struct.unpack_from(">HH", content, at)
        if 0xFFC0 <= marker <= 0xFFCF and marker not in (0xFFC4, 0xFFC8, 0xFFCC):
            height, width = struct.unpack_from(">HH", content, at + 5)
            return PictureHeader(width, height)
        if marker == 0xFFFF:
            at += 1  # filling
        elif marker >> 8 != 0xFF or length < 2:
            raise ValueError(marker)
        else:
            at += 2 + length


def _bmp(content: bytes) -> PictureHeader:
    width, height = struct.unpack_from("<ii", content, 18)
    return PictureHeader(abs(width), abs(height))


def _tiff(content: bytes) -> PictureHeader:
    order = "<" if content[:2] == b"II" else ">"
    tags, after = _directory(content, order, struct.unpack_from(f"{order}I", content, 4)[0])
    # a camera's reduced preview is no second picture
    several = bool(after) and not _directory(content, order, after)[0].get(_SUBFILE, 0) & 1
    return PictureHeader(tags[_WIDTH], tags[_HEIGHT], several, turned=tags.get(_ORIENTATION, 1) != 1)


def _directory(content: bytes, order: str, at: int) -> tuple[dict[int, int], int]:
    """Numbers of a TIFF's directory by tag, as far as they stand in it, and where the next one is; 0 for none."""
    count = struct.unpack_from(f"{order}H", content, at)[0]
    tags = {_WIDTH: 0, _HEIGHT: 0}
    for entry in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", content, entry)
        tags[tag] = struct.unpack_from(f"{order}{'H' if kind == 3 else 'I'}", content, entry + 8)[0]
    return tags, struct.unpack_from(f"{order}I", content, at + 2 + 12 * count)[0]


def _webp(content: bytes) -> PictureHeader:
    kind = content[12:16]
    if kind == b"VP8X":
        width, height = (1 + int.from_bytes(content[at : at + 3], "little") for at in (24, 27))
        return PictureHeader(width, height, several=bool(content[20] & 2))
    if kind == b"VP8L":
        bits = struct.unpack_from("<I", content, 21)[0]
        return PictureHeader(1 + (bits & 0x3FFF), 1 + (bits >> 14 & 0x3FFF))
    width, height = struct.unpack_from("<HH", content, 26)
    return PictureHeader(width & 0x3FFF, height & 0x3FFF)


def _pnm(content: bytes) -> PictureHeader:
    sizes = re.match(rb"P[1-6](?:\s+#[^\n]*)*\s+(\d+)(?:\s+#[^\n]*)*\s+(\d+)", content)
    if sizes is None:
        raise ValueError(content[:16])
    width, height = sizes.groups()
    return PictureHeader(int(width), int(height))


_READERS = (
    (rb"\x89PNG\r\n\x1a\n", _png),
    (rb"\xff\xd8\xff", _jpeg),
    (rb"BM", _bmp),
    (rb"II\*\0|MM\0\*", _tiff),
    (rb"RIFF....WEBP", _webp),
    (rb"P[1-6]\s", _pnm),
)
