"""Whether a PNG is whole: libpng, which decodes it, prints where it is not."""

import struct
import zlib

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_AROUND_BYTES = 12
"""of a chunk: its length and kind before its data, its checksum after them"""


def png_damage(content: bytes) -> str | None:
    """What is wrong with a PNG, in words that follow "is damaged"; None where all that its picture needs is there and unchanged."""
    at = len(PNG_SIGNATURE)
    while at + _AROUND_BYTES <= len(content):
        length, kind = struct.unpack_from(">I4s", content, at)
        end = at + _AROUND_BYTES + length
        if end > len(content):
            break
        # a capital: the picture needs this chunk
        if (
            kind[:1].isupper()
            and zlib.crc32(content[at + 4 : end - 4]) != struct.unpack_from(">I", content, end - 4)[0]
        ):
            return f"after {at} of its {len(content)} bytes: their checksum is wrong"
        if kind == b"IEND":
            return None
        at = end
    return f"at its end, after {len(content)} bytes: the picture goes on"
