"""One .rrd that opens in Rerun with the video, what was found drawn over it, and the curves, all on the log's clock.

Entities are named as the data set's topics and columns: `/state/alpha1`, `/angles/alpha1`, `/simulated/tension2`. What is worked
out for showing alone is under `/state_band` (alpha -+ 2 sigma), `/away` (frames less the state, and +-2 sigma) and `/model`
(lengths of the cables).
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, numbered
from identification.files.joint_state import nanoseconds
from mechanism.cable_lengths import lengths
from xneck.recording.pipeline import Result
from xneck.viewers.panels import colour
from xneck.viewers.rerun_layout import TIMELINE, blueprint
from xneck.viewers.rerun_picture import write_picture
from xneck.viewers.rerun_sdk import rerun_sdk
from xneck_foundation.whole_file import whole_file

CALENDAR_S = 1e9
"""s: a clock that is further counts from 1970, and is shown as a date"""
BAND = 2.0
"""sigma"""
_DOTTED = ("angles", "away")
_DOT, _LINE, _FAINT = 1.0, 1.0, 120
"""points of the screen, and opacity of 255"""


def write_rerun(result: Result, path: str | Path) -> None:
    """All of a recording's result that has a time. Raises Refused where rerun-sdk is not installed."""
    rr = rerun_sdk(path)
    shown = curves(result)
    with whole_file(path) as part, rr.RecordingStream("xneck") as stream:
        stream.save(part)
        # active too: a viewer keeps the layout of the last recording, which may be of another arm
        stream.send_blueprint(blueprint(rr, shown, result.extraction is not None), make_active=True, make_default=True)
        stream.send_recording_name(result.name)
        for topic, series in shown.items():
            _write_curves(rr, stream, topic, series)
        if result.extraction is not None:
            assert result.recording.video is not None
            assert result.camera is not None
            at = time_column(rr, log_time(result.data.clock, result.extraction.angles.time))
            write_picture(rr, stream, result.recording.video, result.data.neck, result.camera, result.extraction, at)
        stream.flush()
        stream.disconnect()


def curves(result: Result) -> dict[str, Series]:
    """What is shown over time, by topic, on the log's clock; SI units and radians."""
    data = result.data
    state = data.state
    shown = {"state": _of_state(data), "angles": _frames(data), "state_band": _band(state), "away": _away(data)}
    shown["model"] = Series(state.time, numbered("length", lengths(data.arm, state.matrix("alpha"))))
    if result.simulated is not None:
        columns = result.simulated.series.columns
        found = {name: values for name, values in columns.items() if not name.endswith("_measured")}
        shown["simulated"] = Series(result.simulated.series.time, found)
    return {topic: series for topic, series in shown.items() if series.columns and len(series)}


def time_column(rr: Any, seconds: np.ndarray) -> Any:
    """Times on the log's clock as Rerun's index."""
    stamps = nanoseconds(seconds)
    if np.abs(seconds[0]) > CALENDAR_S:
        return rr.TimeColumn(TIMELINE, timestamp=stamps.astype("datetime64[ns]"))
    return rr.TimeColumn(TIMELINE, duration=stamps.astype("timedelta64[ns]"))


def _of_state(data: DataSet) -> Series:
    kept = {}
    for stem in ("alpha", "theta", "x", "f"):
        kept |= numbered(stem, data.state.matrix(stem))
    return Series(data.state.time, kept)


def _frames(data: DataSet) -> Series:
    """The camera's angles where the state is; other frames are on no line that could be compared."""
    time = log_time(data.clock, data.angles.time)
    inside = (time >= data.state.time[0]) & (time <= data.state.time[-1])
    return Series(time[inside], numbered("alpha", data.angles.matrix("alpha")[inside]))


def _band(state: Series) -> Series:
    alpha, reach = state.matrix("alpha"), BAND * state.matrix("sigma_alpha")
    return Series(state.time, numbered("alpha", alpha - reach, "_low") | numbered("alpha", alpha + reach, "_high"))


def _away(data: DataSet) -> Series:
    """Frames less the state at their time, and the state's band about zero there."""
    frames, state = _frames(data), data.state

    def there(stem: str) -> np.ndarray:
        return np.stack([np.interp(frames.time, state.time, column) for column in state.matrix(stem).T], axis=-1)

    reach = BAND * there("sigma_alpha")
    away = frames.matrix("alpha") - there("alpha")
    band = numbered("alpha", -reach, "_low") | numbered("alpha", reach, "_high")
    return Series(frames.time, numbered("alpha", away) | band)


def _write_curves(rr: Any, stream: Any, topic: str, series: Series) -> None:
    at = time_column(rr, series.time)
    for name, values in series.columns.items():
        entity, number = f"{topic}/{name}", int(re.sub(r"\D", "", name)) - 1
        limit = name.endswith(("_low", "_high"))
        look = [*_rgb(colour(number)), _FAINT if limit else 255]
        label = f"±2σ {name}" if limit else name if topic == "state" else f"{name} {topic}"
        style = (
            rr.SeriesPoints(colors=look, names=label, marker_sizes=_DOT)
            if topic in _DOTTED and not limit
            else rr.SeriesLines(colors=look, names=label, widths=_LINE)
        )
        stream.log(entity, style, static=True)
        stream.send_columns(entity, indexes=[at], columns=rr.Scalars.columns(scalars=values))


def _rgb(hexadecimal: str) -> list[int]:
    return [int(hexadecimal[k : k + 2], 16) for k in (1, 3, 5)]
