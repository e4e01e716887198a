"""An experiment in time of its own: a muxer writes the video and a logger the log while somebody watches, who only sees the files.

Time passes where the watcher sleeps; what is due by then is written.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from av.container import InputContainer
from av.packet import Packet
from numpy.typing import NDArray

from tests.paths import SAMPLES
from xneck.watch.watch import WallClock

SAMPLE = SAMPLES / "recording"
OPTIONS = {"flush_packets": "1", "cluster_time_limit": "1000"}
"""of the muxer: an mkv that is written second by second, as programs that record write it"""
OFFSET_S = 3.9885
"""s: the log's clock less the camera's, as samples/truth.json has it to 0.1 ms"""
TICK = Fraction(1, 90_000)
Array = NDArray[np.float64]


@dataclass
class Footage:
    """Packets, and the file that they are from, which must stay open as long as they are used."""

    container: InputContainer
    packets: list[Packet]


def footage(path: Path, seconds: float = float("inf")) -> Footage:
    """The packets of a video that are stamped earlier than `seconds`."""
    container = av.open(str(path))
    stream = container.streams.video[0]
    packets = [p for p in container.demux(stream) if p.size and float((p.pts or 0) * p.time_base) < seconds]
    return Footage(container, packets)


@dataclass
class Experiment:
    """Writes a recording into its files as time passes."""

    video: Path
    log: Path
    footage: Footage
    """stamped from about 0 on"""
    lines: Sequence[tuple[float, bytes]]
    """of the log, with the time at which each is written, s of the camera's clock"""
    form: str = "matroska"
    options: dict[str, str] = field(default_factory=dict)
    now_s: float = 0.0
    events: list[tuple[float, dict]] = field(default_factory=list)
    """what was said, and when, s of the camera's clock"""

    def __post_init__(self) -> None:
        self._muxer = av.open(str(self.video), "w", format=self.form, options=OPTIONS | self.options)
        self._packets = self.footage.packets
        self._stream = self._muxer.add_stream_from_template(self.footage.container.streams.video[0])
        self._log = self.log.open("wb", buffering=0)
        self._packet = self._line = 0
        self._open = True

    @property
    def clock(self) -> WallClock:
        """The watcher's."""
        return WallClock(lambda: self.now_s, self._pass)

    def say(self, event: dict) -> None:
        """What the watcher says."""
        self.events.append((self.now_s, event))

    def named(self, kind: str) -> list[tuple[float, dict]]:
        """Findings of a kind, with the time at which each was said."""
        return [(t, e) for t, e in self.events if e["event"] == "finding" and e["kind"] == kind]

    @property
    def findings(self) -> list[str]:
        """Their kinds."""
        return [e["kind"] for _, e in self.events if e["event"] == "finding"]

    def _pass(self, seconds: float) -> None:
        self.now_s += seconds
        while self._packet < len(self._packets):
            packet = self._packets[self._packet]
            assert packet.dts is not None
            if float(packet.dts * packet.time_base) > self.now_s:
                break
            packet.stream = self._stream
            self._muxer.mux(packet)
            self._packet += 1
        while self._line < len(self.lines) and self.lines[self._line][0] <= self.now_s:
            line = self.lines[self._line][1]
            # loggers write blocks, not lines: half of the last line comes with the next block
            self._log.write(line)
            self._line += 1
        if self._open and self._packet == len(self._packets):
            self._muxer.close()
            self._open = False


def encoded(path: Path, frames: Iterable[tuple[float, NDArray[np.uint8]]]) -> Footage:
    """Frames at their stamps, s, encoded anew, as packets."""
    with av.open(str(path), "w", format="matroska") as container:
        stream = container.add_stream("libx264", rate=30, options={"preset": "ultrafast", "crf": "16", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = 1280, 720, "yuv420p"
        stream.codec_context.time_base = TICK
        for time, grey in frames:
            picture = av.VideoFrame.from_ndarray(grey, format="gray").reformat(format="yuv420p")
            picture.pts, picture.time_base = round(time / TICK), TICK
            container.mux(stream.encode(picture))
        container.mux(stream.encode(None))
    return footage(path)


def log_lines(table: dict[str, Array], writes_at: Array) -> list[tuple[float, bytes]]:
    """A CSV in pieces that end anywhere, each with the time at which it is written, s."""
    rows = [",".join(f"{value:.10g}" for value in row) for row in zip(*table.values(), strict=True)]
    pieces: list[tuple[float, bytes]] = [(0.0, (",".join(table) + "\n").encode())]
    held = ""
    for time, row in zip(writes_at.tolist(), rows, strict=True):
        text = held + row + "\n"
        held = text[-7:]
        pieces.append((max(time, 0.0), text[:-7].encode()))
    return [*pieces, (pieces[-1][0], held.encode())]
