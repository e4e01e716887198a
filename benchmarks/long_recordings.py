"""Recordings of any length from short ones: a video over and over, and one motion after another."""

from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, numbered_columns
from samples.generator.prescribed import World, prescribe
from synchronisation.angles import Angles

Array = NDArray[np.float64]

_PAUSE = 3000
"""of the video's time base, between one turn and the next"""
_ROW_S = 0.002


def repeat_video(source: Path, out: Path, times: int) -> None:
    """The video's packets `times` over, without coding them anew."""
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
            shift += last + _PAUSE


def chain(world: World, seconds: float, turns: int, seed: int, noise: float) -> tuple[Angles, Series]:
    """Angles, with noise (rad) in every frame, and log of `turns` motions of so many s, each another one, on two clocks.

    The arm rests where one meets the next, and no frame is seen there. A motion that came again would leave the clock open.
    """
    first = prescribe(world, seconds, [seed, 0]).clocks
    begin, turned = 0.0, list[tuple[Array, ...]]()
    for turn in range(turns):
        made = prescribe(world, seconds, [seed, turn])
        shift = begin - made.log_time[0]
        seen = first.camera_time(made.clocks.log_time(made.frame_times) + shift)
        turned.append((seen, made.frame_alpha, made.log_time + shift, made.counted, made.f))
        begin += len(made.log_time) * _ROW_S
    joined: list[Array] = [np.concatenate(parts) for parts in zip(*turned, strict=True)]
    frames, alpha, rows, theta, f = joined
    alpha = alpha + np.random.default_rng(seed).normal(0, noise, alpha.shape)
    log = Series(np.round(rows, 3), numbered_columns("theta", theta) | numbered_columns("f", f))
    return Angles(frames, alpha, np.full(alpha.shape, noise)), log
