"""One .rrd that opens in Rerun with the video, markers and linkage drawn over it, and the curves, all on the log's clock.

Entities are named as the data set's topics and columns: `/state/alpha1`, `/angles/alpha1`, `/simulated/tension2`. What is
computed for this file alone is under `/state_band` (alpha -+ 2 sigma), `/away` (frames less the state, and +-2 sigma) and `/model`
(lengths of the cables).
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from identification.dataset.series import Series, interpolated, numbered_columns
from identification.files.joint_state import nanoseconds
from mechanism.cable_lengths import lengths
from xneck.recording.recording_result import RecordingResult
from xneck.viewers.panels import curve_colour
from xneck.viewers.rerun_layout import TIMELINE, blueprint
from xneck.viewers.rerun_sdk import rerun_sdk
from xneck_foundation.whole_file import whole_file

MIN_CALENDAR_S = 1e9
"""s: a clock beyond this counts from 1970, and is shown as a date"""
BAND_SIGMAS = 2.0
"""half width of the bands, in standard deviations"""
_DOTTED_TOPICS = ("angles", "away")
_DOT_SIZE, _LINE_WIDTH = 1.0, 1.0
"""points of the screen"""
_BAND_OPACITY = 120
"""of 255"""


def write_rerun(result: RecordingResult, path: str | Path) -> None:
    """Writes all that has a time in a recording's result. Raises Refused where rerun-sdk is not installed."""
    rr = rerun_sdk(path)
    curves = curves_by_topic(result)
    with whole_file(path) as part, rr.RecordingStream("xneck") as stream:
        stream.save(part)
        # active too: a viewer keeps the layout of the last recording, which may be of another arm
        stream.send_blueprint(blueprint(rr, curves, result.video is not None), make_active=True, make_default=True)
        stream.send_recording_name(result.name)
        for topic, series in curves.items():
            _write_curves(rr, stream, topic, series)
        if result.video is not None:
            from xneck.viewers.rerun_video import write_video  # needs PyAV and OpenCV

            assert result.recording.video is not None
            index = time_column(rr, log_time(result.data.clock, result.video.extraction.angles.time))
            write_video(rr, stream, result.recording.video, result.data.neck, result.video, index)
        stream.flush()
        stream.disconnect()


def curves_by_topic(result: RecordingResult) -> dict[str, Series]:
    """The curves by topic, on the log's clock; SI units and radians."""
    data = result.data
    state = data.state
    curves = {
        "state": _state_curves(data),
        "angles": _frame_angles(data),
        "state_band": _state_band(state),
        "away": _frame_residuals(data),
    }
    curves["model"] = Series(state.time, numbered_columns("length", lengths(data.arm, state.matrix("alpha"))))
    if result.simulated is not None:
        columns = result.simulated.series.columns
        simulated = {name: values for name, values in columns.items() if not name.endswith("_measured")}
        curves["simulated"] = Series(result.simulated.series.time, simulated)
    return {topic: series for topic, series in curves.items() if series.columns and len(series)}


def time_column(rr: Any, seconds: np.ndarray) -> Any:
    """Times on the log's clock as Rerun's index."""
    stamps = nanoseconds(seconds)
    if np.abs(seconds[0]) > MIN_CALENDAR_S:
        return rr.TimeColumn(TIMELINE, timestamp=stamps.astype("datetime64[ns]"))
    return rr.TimeColumn(TIMELINE, duration=stamps.astype("timedelta64[ns]"))


def _state_curves(data: DataSet) -> Series:
    columns = {}
    for stem in ("alpha", "theta", "x", "f"):
        columns |= numbered_columns(stem, data.state.matrix(stem))
    return Series(data.state.time, columns)


def _frame_angles(data: DataSet) -> Series:
    """The camera's angles on the log's clock, of the frames within the state's time."""
    time = log_time(data.clock, data.angles.time)
    inside = (time >= data.state.time[0]) & (time <= data.state.time[-1])
    return Series(time[inside], numbered_columns("alpha", data.angles.matrix("alpha")[inside]))


def _state_band(state: Series) -> Series:
    alpha, half_width = state.matrix("alpha"), BAND_SIGMAS * state.matrix("sigma_alpha")
    return Series(
        state.time,
        numbered_columns("alpha", alpha - half_width, "_low") | numbered_columns("alpha", alpha + half_width, "_high"),
    )


def _frame_residuals(data: DataSet) -> Series:
    """Angles of the frames less the state at their time, and the state's band about zero."""
    frames, state = _frame_angles(data), data.state

    def at_frames(stem: str) -> np.ndarray:
        return interpolated(frames.time, state.time, state.matrix(stem))

    half_width = BAND_SIGMAS * at_frames("sigma_alpha")
    residual = frames.matrix("alpha") - at_frames("alpha")
    band = numbered_columns("alpha", -half_width, "_low") | numbered_columns("alpha", half_width, "_high")
    return Series(frames.time, numbered_columns("alpha", residual) | band)


def _write_curves(rr: Any, stream: Any, topic: str, series: Series) -> None:
    index = time_column(rr, series.time)
    for name, values in series.columns.items():
        entity, number = f"{topic}/{name}", int(re.sub(r"\D", "", name)) - 1
        limit = name.endswith(("_low", "_high"))
        colour = [*_rgb(curve_colour(number)), _BAND_OPACITY if limit else 255]
        label = f"±2σ {name}" if limit else name if topic == "state" else f"{name} {topic}"
        style = (
            rr.SeriesPoints(colors=colour, names=label, marker_sizes=_DOT_SIZE)
            if topic in _DOTTED_TOPICS and not limit
            else rr.SeriesLines(colors=colour, names=label, widths=_LINE_WIDTH)
        )
        stream.log(entity, style, static=True)
        stream.send_columns(entity, indexes=[index], columns=rr.Scalars.columns(scalars=values))


def _rgb(hexadecimal: str) -> list[int]:
    return [int(hexadecimal[k : k + 2], 16) for k in (1, 3, 5)]
