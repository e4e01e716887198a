"""What is opened as a video: one local file in a listed container, read as it is, or refused for what it is."""

import contextlib
import os
import shutil
import socket
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import av
import numpy as np
import pytest

from tests.vision.test_video import STAMPS, film
from vision.video import describe_video, read_frames
from xneck_foundation.errors import Refused


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a film in every container, and a secret outside of the folder in which the tests write."""
    folder = tmp_path_factory.mktemp("films")
    for name in ("a.mp4", "a.mkv", "a.ts", "a.mov"):
        film(folder / name, STAMPS, {".mkv": "matroska", ".ts": "mpegts"}.get(Path(name).suffix, name[2:]))
    return folder


@dataclass
class Listener:
    """A local server that hangs up on everybody, and who called it."""

    port: int
    callers: list[object] = field(default_factory=list)


@pytest.fixture
def listener() -> Iterator[Listener]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        found = Listener(server.getsockname()[1])

        def answer() -> None:
            with contextlib.suppress(OSError):  # the server was shut down
                while True:
                    connection, caller = server.accept()
                    found.callers.append(caller)
                    connection.close()

        thread = threading.Thread(target=answer)
        thread.start()
        yield found
        server.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_the_listener_notices_a_caller(listener: Listener) -> None:
    with socket.create_connection(("127.0.0.1", listener.port)) as connection:
        connection.recv(1)
    assert len(listener.callers) == 1


def levels(path: Path) -> list[float]:
    return [float(np.median(frame.grey[16:])) for frame in read_frames(path)]


M3U8 = "#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:2\n#EXTINF:1.3,\n{}\n#EXT-X-ENDLIST\n"
DASH = (
    '<?xml version="1.0"?>\n<MPD xmlns="urn:mpeg:dash:schema:mpd:2011" type="static" mediaPresentationDuration="PT1S" '
    'profiles="urn:mpeg:dash:profile:isoff-on-demand:2011"><Period><AdaptationSet mimeType="video/mp4">'
    '<Representation id="1" bandwidth="9" width="96" height="64"><BaseURL>{}</BaseURL></Representation>'
    "</AdaptationSet></Period></MPD>"
)
SDP = (
    "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\na=rtpmap:96 H264/90000\n{}"
)
LISTS = {
    "playlist.m3u8": (M3U8, r"is a playlist \(m3u8\), which would read other files"),
    "playlist.mp4": (M3U8, r"is a playlist \(m3u8\), which would read other files"),
    "list.ffconcat": ("ffconcat version 1.0\nfile '{}'\n", r"is a list for FFmpeg \(ffconcat\), which would read"),
    "list.mp4": ("ffconcat version 1.0\nfile '{}'\n", r"is a list for FFmpeg \(ffconcat\), which would read"),
    "manifest.mpd": (DASH, "is a DASH manifest, which would read"),
    "manifest.mp4": (DASH, "is a DASH manifest, which would read"),
    "stream.sdp": (SDP, r"is a description of a stream \(SDP\), which would read"),
    "link.mp4": ("[InternetShortcut]\r\nURL={}\r\n", "is a playlist or a link, which would read"),
    "address.mp4": ("rtsptext\n{}\n", "is the address of a stream, which would read"),
    "players.mp4": ('<asx version="3.0"><entry><ref href="{}"/></entry></asx>', r"is a playlist \(XML\), which would"),
    "words.idx": ("# VobSub index file, v7\n{}\n", "is an index of subtitles, which would read"),
}


@pytest.mark.parametrize("name", LISTS)
def test_a_list_of_other_files_is_refused_by_name_and_opens_none(
    name: str, whole: Path, tmp_path: Path, listener: Listener
) -> None:
    """Neither a file beside it, nor one elsewhere, nor an address is opened: no frame comes, nor does a caller."""
    text, reason = LISTS[name]
    shutil.copy(whole / "a.ts", tmp_path / "beside.ts")
    port = listener.port
    for target in ("beside.ts", whole / "a.ts", f"http://127.0.0.1:{port}/a.ts", f"tcp://127.0.0.1:{port}"):
        (tmp_path / name).write_text(text.format(target))
        with pytest.raises(Refused, match=reason):
            list(read_frames(tmp_path / name))
    assert listener.callers == []


def test_names_that_ffmpeg_would_take_for_addresses_are_names(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, listener: Listener
) -> None:
    monkeypatch.chdir(tmp_path)
    address = f"http:/127.0.0.1:{listener.port}/a.mp4"
    for name in (address, "concat:a.mp4|b.mp4", "pipe:0", "file:a.mp4", "data:video,x", "a%03d.mp4"):
        with pytest.raises(Refused, match="does not exist"):
            describe_video(name)
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(whole / "a.mp4", name)
        assert len(levels(Path(name))) == len(STAMPS)
    assert listener.callers == []


def test_a_name_that_is_no_utf_8(whole: Path, tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe.mp4"))
    shutil.copy(whole / "a.mp4", path)
    assert len(levels(path)) == len(STAMPS)


def test_a_pattern_of_names_stands_for_no_other_files(tmp_path: Path) -> None:
    for k in range(3):
        (tmp_path / f"a{k:03d}.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    (tmp_path / "a%03d.png").write_bytes(b"x")
    with pytest.raises(Refused, match="is no video in mp4"):
        describe_video(tmp_path / "a%03d.png")


def test_what_is_no_regular_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.mp4")
    for path in (tmp_path / "a.mp4", Path("/dev/zero")):
        with pytest.raises(Refused, match="is no file but a pipe or a device"):
            describe_video(path)


def gif(path: Path) -> None:
    path.write_bytes(b"GIF89a" + bytes(100))


def flash(path: Path) -> None:
    film(path, STAMPS, "flv")


def plain(content: bytes) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        path.write_bytes(content)

    return write


OTHERS = {
    "empty": (plain(b""), "is empty"),
    "text": (plain(b"this is not a film\n" * 100), "is no video in mp4"),
    "PNG": (plain(b"\x89PNG\r\n\x1a\n" + bytes(100)), "is a picture; give a video"),
    "JPEG": (plain(b"\xff\xd8\xff\xe0" + bytes(100)), "is a JPEG picture, or a bare stream"),
    "GIF": (gif, "is a GIF"),
    "flash": (flash, "is a video, but none in mp4.*ffmpeg -i IN -c copy OUT.mkv"),
}


@pytest.mark.parametrize("kind", OTHERS)
def test_what_is_no_video_in_a_listed_container_is_refused_for_what_it_is(kind: str, tmp_path: Path) -> None:
    write, reason = OTHERS[kind]
    write(tmp_path / "a.mp4")
    with pytest.raises(Refused, match=reason):
        describe_video(tmp_path / "a.mp4")


def with_reference(data: bytes, entry: bytes) -> bytes:
    """An mp4 (its index last) whose data reference is `entry` instead of the one that says: in this file."""
    changed = bytearray(data)
    at = changed.index(b"url ") - 4
    size = int.from_bytes(changed[at : at + 4], "big")
    changed[at : at + size] = entry
    for kind in (b"moov", b"trak", b"mdia", b"minf", b"dinf", b"dref"):
        box = changed.index(kind, changed.index(b"moov")) - 4
        longer = int.from_bytes(changed[box : box + 4], "big") + len(entry) - size
        changed[box : box + 4] = longer.to_bytes(4, "big")
    return bytes(changed)


def test_an_mp4_whose_pictures_lie_in_another_file_is_refused(whole: Path, tmp_path: Path) -> None:
    with av.open(str(whole / "a.mp4")) as source, av.open(str(tmp_path / "own.mp4"), "w") as out:
        stream = out.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                out.mux(packet)
    data, place = (tmp_path / "own.mp4").read_bytes(), f"file://{whole / 'a.mp4'}".encode() + b"\0"
    assert len(levels(tmp_path / "own.mp4")) == len(STAMPS)
    for kind in (b"url ", b"alis"):
        entry = (12 + len(place)).to_bytes(4, "big") + kind + bytes(4) + place
        (tmp_path / "a.mp4").write_bytes(with_reference(data, entry))
        with pytest.raises(Refused, match="keeps its pictures in another file"):
            describe_video(tmp_path / "a.mp4")


@pytest.mark.parametrize("name", ["a.mkv", "a.avi", "a.mov", "a.mp4"])
def test_a_container_that_is_shorter_than_it_says_is_truncated(name: str, whole: Path, tmp_path: Path) -> None:
    path = tmp_path / name
    film(path, STAMPS, "avi") if name == "a.avi" else shutil.copy(whole / name, path)
    assert len(levels(path)) == len(STAMPS)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(Refused, match="is truncated"):
        describe_video(path)
