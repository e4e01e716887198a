"""Which files are opened as videos: regular files in a listed container, and nothing that they name.

FFmpeg opens whatever a name or a text says: playlists, lists of files, addresses, patterns of names. Here it gets one local file,
one protocol and few containers, so that it reads that file and nothing else.
"""

import re
from pathlib import Path

import av
import av.container
import av.error
from av.stream import Disposition
from av.video.stream import VideoStream

from vision.container_layout import MP4_BEGINNINGS, is_joined, names_other_file, truncation
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

CONTAINERS = ("mov,mp4,m4a,3gp,3g2,mj2", "matroska,webm", "avi", "mpegts")
"""FFmpeg's names of the containers that are read: what cameras, camcorders, phones and OBS write, with stamps of their own"""
CONTAINER_NAMES = "mp4, mov, mkv, webm, avi or MPEG-TS"
_OPTIONS = {"protocol_whitelist": "file", "format_whitelist": ",".join(CONTAINERS)}
_REWRITE = "put it into mkv without loss: ffmpeg -i IN -c copy OUT.mkv"
_HEAD_BYTES = 1024

_LISTS = (
    (rb"#EXTM3U", "a playlist (m3u8)"),
    (rb"ffconcat", "a list for FFmpeg (ffconcat)"),
    (rb"(<\?xml.*?)?<MPD\b", "a DASH manifest"),
    (rb"(<\?xml.*?)?<(CompositionPlaylist|smil|asx|playlist)\b", "a playlist (XML)"),
    (rb"\[(playlist|InternetShortcut|Reference)\]", "a playlist or a link"),
    (rb"v=0\s", "a description of a stream (SDP)"),
    (rb"rtsptext|[a-z]{3,5}://", "the address of a stream"),
    (rb"# VobSub", "an index of subtitles"),
)
"""beginnings of texts by which FFmpeg would read other files, or the network"""
_OTHERS = (
    (
        rb"\x89PNG|BM....\0\0\0\0|II\*\0|MM\0\*|RIFF....WEBP|P[1-6]\s",
        "is a picture",
        f"give a video: {CONTAINER_NAMES}",
    ),
    (rb"GIF8", "is a GIF", f"give a video: {CONTAINER_NAMES}"),
    (
        rb"\xff\xd8\xff",
        "is a JPEG picture, or a bare stream of them without time stamps",
        "record into mp4 or mkv",
    ),
    (
        rb"\0\0\x01\xba|FLV|OggS|0&\xb2u|DKIF|YUV4MPEG2|nut/multimedia",
        f"is a video, but none in {CONTAINER_NAMES}",
        _REWRITE,
    ),
    (rb"\0?\0\0\x01", "is a bare stream without time stamps", "record into mp4 or mkv"),
)
"""beginnings of other files, what each is, and what to do"""


def open_video(path: Path) -> tuple[av.container.InputContainer, VideoStream]:
    """The container of a video file, to be closed, and its first video stream that is no cover picture.

    Raises Refused, with what the file is, for all that is no regular file with a video in a listed container.
    """
    check_input(path)
    try:
        # an absolute name after the protocol: no name is taken for an address, a device or a list of names
        container = av.open(f"file:{path.absolute()}", container_options=_OPTIONS, metadata_errors="replace")
    except (av.error.FFmpegError, ValueError) as error:
        raise refusal_of(path, getattr(error, "strerror", None) or str(error)) from error
    streams = videos_in(container)
    if streams:
        return container, streams[0]
    cover = ", only a cover picture" if container.streams.video else ""
    container.close()
    raise Refused(path, f"has no video in it{cover}", "is it the right file?")


def videos_in(container: av.container.InputContainer) -> list[VideoStream]:
    """The video streams of a container that are no cover picture."""
    return [stream for stream in container.streams.video if not stream.disposition & Disposition.attached_pic]


def refuse_incomplete(path: Path) -> None:
    """Raises Refused where the container says that the file is cut short, holds two videos, or keeps its pictures elsewhere."""
    if (shown_by := truncation(path)) is not None:
        raise Refused(path, f"is truncated: {shown_by}", "copy the file again, or record again")
    if is_joined(path):
        raise Refused(path, "is several videos joined end to end", "give each by itself")
    if names_other_file(path):
        raise Refused(path, "keeps its pictures in another file, which is not read", "save it with its pictures in it")


def refusal_of(path: Path, error: str) -> Refused:
    """Why FFmpeg did not open a file, by what the file begins with; `error` is what FFmpeg says."""
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD_BYTES)
    except OSError as failure:
        return Refused(path, f"cannot be read ({failure.strerror})")
    if not head:
        return Refused(path, "is empty", "record again, or copy the file again")
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    for beginning, what in _LISTS:
        if re.match(beginning, text, re.DOTALL | re.IGNORECASE):
            return Refused(path, f"is {what}, which would read other files or the network", "give the video itself")
    for beginning, what, do in _OTHERS:
        if re.match(beginning, head, re.DOTALL):
            return Refused(path, what, do)
    if not (head[4:8] in MP4_BEGINNINGS or re.match(rb"\x1aE\xdf\xa3|RIFF....AVI ", head, re.DOTALL)):
        return Refused(path, f"is no video in {CONTAINER_NAMES}", "is it the right file?")
    if (shown_by := truncation(path)) is not None:
        return Refused(path, f"is truncated: {shown_by}", "copy the file again, or record again")
    return Refused(path, f"is damaged at its beginning ({error})", "copy the file again")
