"""The sample's video: frames at their true instants, H.264 in MP4, the same bytes for the same seed.

A frame's stamp is the middle of its exposure. Frames that the camera lost are not in the list of times, so that the
file's stamps have gaps, as those of a real recording have.
"""

import multiprocessing
import struct
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
from av.video.frame import PictureType
from numpy.typing import ArrayLike, NDArray

from samples.generator.camera import Camera
from samples.generator.frame import render_frame
from samples.generator.trouble import NONE, Trouble

TICKS = 90_000
"""stamps are whole multiples of 1 / TICKS s"""
KEYFRAME_S = 0.9
"""longest time between key frames, s"""

Job = tuple[int, NDArray[np.float64], Trouble]
"""a frame's number, its joint angles over the exposure, and what it suffers from"""


@dataclass(frozen=True)
class Look:
    """Choices that change the picture or its coding, not the motion."""

    payload: bool = True
    """show the weight that was left on the tip"""
    wall_seed: int = 0
    instants: int = 5
    """positions of the arm averaged over one exposure"""
    crf: float = 22.5
    """x264's constant quality: more is smaller and coarser"""


def render_video(
    path: str | Path,
    frame_times: ArrayLike,
    alpha_at: Callable[[float], ArrayLike],
    neck: dict[str, Any],
    camera: Camera,
    seed: int,
    look: Look | None = None,
    processes: int = 1,
    trouble_at: Callable[[float], Trouble] = lambda time: NONE,
    turned: bool = False,
) -> None:
    """Render and encode an arm's motion.

    `frame_times`: middles of the exposures, shape (F,), s, increasing, on the camera's clock, from 0 on.
    `alpha_at`: the joint angles at a time of that clock, shape (N,), rad.
    `neck`: the contents of neck.yaml; without `markers` the arm has no plates.
    `processes` changes nothing but the time it takes.
    `trouble_at`: what comes between the markers and the camera at a time of that clock.
    `turned`: store the pictures on their side, with the tag by which a player sets them upright, as a phone does.
    """
    look = look or Look()
    stamps = np.rint(np.asarray(frame_times, dtype=float) * TICKS).astype(np.int64)
    if len(stamps) == 0 or stamps[0] < 0 or (np.diff(stamps) <= 0).any():
        raise ValueError(f"{path}: frame times must start at or after 0 and increase by more than 1/{TICKS} s")
    parts = (np.arange(look.instants) + 0.5) / look.instants - 0.5
    jobs = (
        (k, np.array([np.asarray(alpha_at(t + p * camera.exposure_s), dtype=float) for p in parts]), trouble_at(t))
        for k, t in enumerate(np.asarray(frame_times, dtype=float))
    )
    draw = partial(_draw, neck=neck, camera=camera, seed=seed, look=look)
    pictures = _all_frames(draw, jobs, processes)
    if not turned:
        encode(path, stamps, pictures, camera.size, look.crf)
        return
    encode(path, stamps, (np.ascontiguousarray(np.rot90(p)) for p in pictures), (camera.height, camera.width), look.crf)
    tag_as_turned(path)


def encode(
    path: str | Path, stamps: NDArray[np.int64], frames: Iterator[NDArray[np.uint8]], size: tuple[int, int], crf: float
) -> None:
    """Write colour pictures, each of shape (h, w, 3), with their stamps, shape (F,), in 1 / TICKS s."""
    # the second scale is that of the edit list, which holds the first frame's offset: by default only to 1 ms
    scales = {"video_track_timescale": str(TICKS), "movie_timescale": str(TICKS)}
    with av.open(str(path), "w", format="mp4", options=scales) as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, TICKS)
        # one thread and no B-frames: the same bytes on every machine, and a decoding order that is the order of time
        stream.options = {
            "crf": str(crf),
            "preset": "slow",
            "x264-params": "threads=1:lookahead-threads=1:bframes=0:keyint=100000:scenecut=0:force-cfr=0",
        }
        context = stream.codec_context
        context.thread_count = 1
        context.color_range, context.colorspace = 1, 1  # limited range, BT.709: said in the file, not left to guess
        context.color_primaries, context.color_trc = 1, 1
        last_key = -TICKS
        for stamp, picture in zip(stamps.tolist(), frames, strict=True):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(
                format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG"
            )
            frame.pts, frame.time_base = stamp, Fraction(1, TICKS)
            if stamp - last_key >= KEYFRAME_S * TICKS:
                frame.pict_type = PictureType.I
                last_key = stamp
            for packet in stream.encode(frame):
                container.mux(packet)
        for packet in stream.encode(None):
            container.mux(packet)


def tag_as_turned(path: str | Path, *, half: bool = False) -> None:
    """Write the display matrix of a quarter (clockwise) or half turn into an MP4's only track header (ISO 14496-12 8.3.2)."""
    data = bytearray(Path(path).read_bytes())
    upright = struct.pack(">9i", 65536, 0, 0, 0, 65536, 0, 0, 0, 0x40000000)
    rows = (-65536, 0, 0, 0, -65536, 0) if half else (0, 65536, 0, -65536, 0, 0)
    turned = struct.pack(">9i", *rows, 0, 0, 0x40000000)
    at = data.index(upright, data.index(b"tkhd"))
    data[at : at + len(turned)] = turned
    Path(path).write_bytes(data)


def _draw(job: Job, neck: dict[str, Any], camera: Camera, seed: int, look: Look) -> NDArray[np.uint8]:
    """One frame; its noise depends on the seed and its number only, not on who draws it."""
    number, alpha, suffers = job
    rng = np.random.default_rng([seed, 2, number])
    return render_frame(alpha, neck, camera, rng, payload=look.payload, wall_seed=look.wall_seed, suffers=suffers)


def _all_frames(
    draw: Callable[[Job], NDArray[np.uint8]],
    jobs: Iterator[Job],
    processes: int,
) -> Iterator[NDArray[np.uint8]]:
    if processes == 1:
        yield from map(draw, jobs)
        return
    fresh = multiprocessing.get_context("spawn")  # OpenCV's and the encoder's threads do not survive a fork
    with ProcessPoolExecutor(processes, mp_context=fresh, initializer=cv2.setNumThreads, initargs=(1,)) as pool:
        while batch := list(islice(jobs, 8 * processes)):  # batches bound the memory
            yield from pool.map(draw, batch)
