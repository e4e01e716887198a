"""A long recording simulated part by part, its series in a file.

Each part has its own pre-elongation and delay, as a recording of its own would. The error of a channel and its noise floor are root
mean squares over all parts. The laws' numbers err alike in all of them, so that the ratio which a true model exceeds in 5 of 100
recordings is taken to be no closer to one than that of any part.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from identification.dataset.columns_on_disk import SeriesOnDisk
from identification.dataset.dataset import DataSet
from identification.model_file import Model
from identification.simulation.channels import Channel
from identification.simulation.simulated_recording import Progress, SimulatedRecording, Source, simulate_recording
from xneck_foundation.errors import Refused

MAX_ROWS = 6_000_000
"""rows of a simulated recording (docs/thresholds.md)"""


def simulate_parts(
    parts: Iterable[DataSet], model: Model, window_s: float, source: Source, progress: Progress, scratch: Path
) -> SimulatedRecording:
    """As `simulate_recording`, of consecutive parts that are whole windows; its series lies on the disk of the folder `scratch`.

    `parameters` are those of the first part. Raises Refused as `simulate_recording` does, and beyond MAX_ROWS.
    """
    series, simulated, seconds = SeriesOnDisk(scratch, MAX_ROWS), list[SimulatedRecording](), list[float]()
    rows = 0
    for part in parts:
        one = simulate_recording(part, model, window_s, source, progress)
        rows += len(one.series)
        if rows > MAX_ROWS:
            raise Refused("simulate", f"more than {MAX_ROWS} rows", "simulate shorter recordings")
        series.write(one.series)
        seconds.append(float(len(one.series)))
        simulated.append(replace(one, series=one.series.part(slice(0, 0))))
    channels = tuple(
        _merged([one.channels[k] for one in simulated], seconds) for k in range(len(simulated[0].channels))
    )
    return replace(simulated[0], series=series.series(), channels=channels)


def _merged(parts: Sequence[Channel], weight: Sequence[float]) -> Channel:
    def rms(values: Sequence[float]) -> float:
        return float(np.sqrt(np.average(np.square(values), weights=weight)))

    return replace(
        parts[0],
        rms=rms([part.rms for part in parts]),
        noise_floor=rms([part.noise_floor for part in parts]),
        ratio_95=max(part.ratio_95 for part in parts),
    )
