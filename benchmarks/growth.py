"""How following a video grows with its length: time and peak memory of a process of its own, decoding beside it."""

import subprocess
import sys
import tempfile
from pathlib import Path

import av

from benchmarks.table import Table

SAMPLES = Path(__file__).parents[1] / "samples"
TIMES = (1, 5, 50)
"""how often the sample's 24 s are repeated: 24 s, 2 min, 20 min"""

_CALL = """
import resource, sys, time
from mechanism.description import read_neck
from vision.following import follow
from vision.video import describe, frames
video, neck = describe(sys.argv[1]), read_neck(sys.argv[2])
begin = time.perf_counter()
if sys.argv[3] == "follow":
    count = len(follow(video, neck.markers).time)
else:
    count = sum(1 for _ in frames(video.path))
print(count, time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def measure() -> Table:
    """ms a frame, ratio to decoding alone, and peak memory in MB, at three lengths."""
    rows: list[tuple[str, tuple[float | None, ...]]] = []
    with tempfile.TemporaryDirectory() as folder:
        for times in TIMES:
            video = Path(folder) / f"{times}.mp4"
            repeat(SAMPLES / "recording/video.mp4", video, times)
            count, spent, peak = _run(video, "follow")
            _, decoding, _ = _run(video, "decode")
            rows.append((f"{count:.0f} frames", (1e3 * spent / count, spent / decoding, peak / 1e3)))
    return Table("Following markers, growth with length", ("ms a frame", "over decoding", "peak MB"), tuple(rows))


def repeat(source: Path, out: Path, times: int) -> None:
    """The video's packets `times` over, one after the other, without coding them anew."""
    with av.open(str(out), "w") as target:
        stream, shift = None, 0
        for _ in range(times):
            last = 0
            with av.open(str(source)) as container:
                video = container.streams.video[0]
                stream = stream or target.add_stream_from_template(video)
                for packet in container.demux(video):
                    if packet.pts is None or packet.dts is None:
                        continue
                    last = max(last, packet.pts)
                    packet.pts, packet.dts, packet.stream = packet.pts + shift, packet.dts + shift, stream
                    target.mux(packet)
            shift += last + 3000


def _run(video: Path, what: str) -> tuple[float, float, float]:
    call = [sys.executable, "-c", _CALL, str(video), str(SAMPLES / "recording/neck.yaml"), what]
    count, spent, peak = subprocess.run(call, capture_output=True, text=True, check=True).stdout.split()
    return float(count), float(spent), float(peak)
