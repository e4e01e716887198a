"""The controller's log: motor angles theta and forces f on its own clock, brought into our signs and units."""

from collections.abc import Callable, Collection, Mapping
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.dataset.series import Series, check_size, check_time, from_one, numbered_columns
from identification.dataset.time_unit import check_repeated_rows, check_time_unit
from identification.files import joint_state, ros_bag
from mechanism.description import Neck
from synchronisation.clock_steps import clock_steps
from synchronisation.column_units import TIME_SCALES
from synchronisation.csv_header import WrittenOtherwise
from synchronisation.csv_lines import file_line
from synchronisation.csv_table import CsvFormat, read_table
from synchronisation.motor_counters import F_OUTLIER_RANGE, THETA_OUTLIER_RANGE, absurd_samples, row_of_reset, unwrapped
from synchronisation.motor_topic import LED, motor_channel
from synchronisation.parquet_table import read_parquet
from synchronisation.row_order import in_order
from synchronisation.said_units import check_units
from synchronisation.time_stamps import check_log_rate, sampling_step
from synchronisation.uneven_stamps import even_times_of
from xneck_foundation.errors import Refused
from xneck_foundation.file_kind import refuse_other_kind
from xneck_foundation.one_line import counted, listed
from xneck_foundation.recovery import warn_recovered

Array = NDArray[np.float64]

LOG_SUFFIXES = (".csv", ".parquet", ".mcap", ".bag", ".db3")
"""of logs that are read"""
MAX_LOGGED_MAGNITUDE = 1e9
"""largest motor angle or force that a log may hold, in whatever unit it is logged (docs/thresholds.md)"""
MAX_LOG_ROWS = 5_000_000
"""rows of a log beyond which it is refused: nearly three hours at 500 Hz (docs/thresholds.md)"""

_MAX_CUBIC_STEPS = 4.5
"""between the first and the last of four rows: where it is more some are missing"""
_ROWS_LATE, _MISSED_ROWS = 5, 0.5
"""rows one after the other that may be late, and the delay, in rows, of all of so many from which some are missing"""
_ROWS_AT_ONCE = 100_000
"""that are interpolated: memory stays flat"""


def read_log(path: str | Path, neck: Neck) -> Series:
    """Columns theta1..M (rad, motor side, winding in positive) and f1..M (N) of a CSV, Parquet, MCAP or ROS bag.

    A log without any f is accepted: then its clock is known to a few milliseconds only and nothing can be identified.
    A column `led` (in an MCAP the position of a joint of that name), 0 or 1, says whether a light was on that the video shows.

    Raises Refused where columns or joints are missing, values not finite, or times do not increase.

    >>> import xneck
    >>> log = xneck.read_log("samples/recording/log.mcap", xneck.read_neck("samples/recording/neck.yaml"))
    >>> log.matrix("theta").shape == (len(log), 4)  # rad
    True
    """
    path = Path(path)
    if path.suffix.lower() == ".mcap":
        file = joint_state.read(path)
        return motor_log(motor_channel(file.logs, neck, path, file.faults), neck, path)
    if path.suffix.lower() in ros_bag.SUFFIXES:
        bag = ros_bag.read_bag(path)
        return motor_log(motor_channel(bag.logs, neck, path, bag.faults), neck, path)
    required, optional = log_columns(neck)
    number: Callable[[int], int] = from_one
    if path.suffix.lower() == ".parquet":
        series = read_parquet(path, required, optional, neck.log.time_column)
    else:
        number = file_line(path, neck.log.separator, int(neck.log.units_row))
        refuse_other_kind(path, LOG_SUFFIXES)
        try:
            series = read_table(
                path, required, optional, csv_format(neck), MAX_LOG_ROWS, partial(check_column_units, path, neck)
            )
        except WrittenOtherwise as lack:
            raise Refused(path, lack.what, f"{lack.do}; or let `xneck logs {path.name}` map it") from lack
    check_column_units(path, neck, {})
    check_columns(path, series.columns, neck)
    return motor_log(mapped_columns(series, neck), neck, path, number)


def check_column_units(path: Path, neck: Neck, below_header: Mapping[str, str]) -> None:
    """Raises Refused where the units of a table's columns, in their names or in a row below the header, are not neck.yaml's."""
    angles, forces = _named_columns(neck)
    check_units(path, neck, angles, forces, below_header)


def csv_format(neck: Neck) -> CsvFormat:
    """How neck.yaml says that a CSV is written."""
    return CsvFormat(neck.log.time_column, neck.log.separator, neck.log.decimal, neck.log.units_row)


def log_columns(neck: Neck) -> tuple[list[str], list[str]]:
    """The columns that a table must have beside its time, and those that are looked for, as neck.yaml names them."""
    angles, forces = _named_columns(neck)
    if neck.log.nanoseconds_column is not None:
        angles.append(neck.log.nanoseconds_column)
    further = [] if neck.motors[0].theta_column else [f"theta{neck.M + 1}"]
    if neck.motors[0].f_column:
        return [*angles, *forces], [neck.log.led_column, *further]
    return angles, [*forces, neck.log.led_column, *further]


def _named_columns(neck: Neck) -> tuple[list[str], list[str]]:
    """The columns of the motors' angles, and of their forces."""
    angles = [motor.theta_column or f"theta{j + 1}" for j, motor in enumerate(neck.motors)]
    return angles, [motor.f_column or f"f{j + 1}" for j, motor in enumerate(neck.motors)]


def check_columns(path: Path, columns: Collection[str], neck: Neck) -> None:
    """Raises Refused where a table has columns of more motors than neck.yaml, or forces of some only."""
    further = f"theta{neck.M + 1}"
    if further in columns and not neck.motors[0].theta_column:
        raise Refused(path, f"has {further}, and neck.yaml has {neck.M} motors", "is it this arm's neck.yaml?")
    missing = [name for name in _named_columns(neck)[1] if name not in columns]
    if 0 < len(missing) < neck.M:
        raise Refused(
            path,
            f"lacks the column{'s' * (len(missing) > 1)} {listed(missing)}",
            "log the forces of all motors, or of none",
        )


def mapped_columns(series: Series, neck: Neck) -> Series:
    """Columns theta, f and led of a table, whose columns are called as neck.yaml says; time in s."""
    angles, forces = _named_columns(neck)
    columns = numbered_columns("theta", np.column_stack([series.columns[name] for name in angles]))
    if forces[0] in series.columns:
        columns |= numbered_columns("f", np.column_stack([series.columns[name] for name in forces]))
    if neck.log.led_column in series.columns:
        columns[LED] = series.columns[neck.log.led_column]
    time = series.time * neck.log.time_scale
    if neck.log.nanoseconds_column is not None:
        time += TIME_SCALES["ns"] * series.columns[neck.log.nanoseconds_column]
    return Series(time, columns)


def motor_log(series: Series, neck: Neck, path: str | Path, number: Callable[[int], int] = from_one) -> Series:
    """Columns as `path` holds them, in our signs and units: as `read_log` gives them, and refuses them.

    number: what a person calls a row, which is counted from 0."""
    if len(series) > MAX_LOG_ROWS:
        raise Refused(path, f"has more than {MAX_LOG_ROWS} rows", "cut log and angles in parts, hours each")
    check_repeated_rows(series, str(path), "rows")
    series, kept = in_order(series, path)
    check_time_unit(series.time, str(path), "rows")
    check_time(series.time, str(path), lambda row: number(int(kept[row])))
    check_log_rate(series.time, str(path))
    for name, values in series.columns.items():
        if not np.all(np.isfinite(values)):
            row = number(int(kept[np.argmin(np.isfinite(values))]))
            raise Refused(path, f"{name} is not a number in row {row}", "leave such rows out")
    neither = ~np.isin(series.columns.get(LED, np.empty(0)), (0, 1))
    if neither.any():
        raise Refused(path, f"{LED} is neither 0 nor 1 in row {number(int(kept[np.argmax(neither)]))}")
    # an absurd sample hides what wraps, and a wrap is none: angles are unwrapped before and after
    series = _without_absurd_samples(_unwrapped(series, neck, path), path)
    series = _from_reset_on(_unwrapped(series, neck, path), path)
    check_size(series.columns, MAX_LOGGED_MAGNITUDE, str(path))
    series = _at_times_of_sampling(_without_clock_steps(series, path), path)
    theta_scale = np.array([motor.theta_sign * motor.theta_scale for motor in neck.motors])
    f_scale = np.array([motor.f_scale for motor in neck.motors])
    columns = numbered_columns("theta", series.matrix("theta") * theta_scale)
    if "f1" in series.columns:
        columns |= numbered_columns("f", series.matrix("f") * f_scale)
    if LED in series.columns:
        columns[LED] = series.columns[LED]
    return Series(series.time, columns)


def _without_clock_steps(series: Series, path: str | Path) -> Series:
    """The rows on the clock as it was before it was set, with a warning, where stamps leap and the motors do not."""
    steps = clock_steps(series.time, series.matrix("theta"))
    at = np.flatnonzero(steps)
    if not len(at):
        return series
    first = int(at[0])
    where = f"by {1e3 * steps[first]:.3g} ms at {series.time[first]:.6g} s"
    more = f", and {counted(len(at) - 1, 'time')} more" if len(at) > 1 else ""
    warn_recovered(
        path,
        f"stamps leap forward {where}{more}, and the motors do not: the clock was set, and times behind it are taken to be that "
        "much earlier; switch off what sets the clock (NTP) while you record",
    )
    return Series(series.time - np.cumsum(steps), series.columns)


def _at_times_of_sampling(series: Series, path: str | Path) -> Series:
    """The rows at even times, with a warning, where the motors' angles tell that they were sampled so, and not as stamped."""
    even = even_times_of(series.time, series.matrix("theta"))
    if even is None:
        return series
    warn_recovered(
        path,
        f"stamps are {1e3 * even.spread:.2g} ms (rms) beside the times at which the motors' angles go on smoothly, "
        f"one row every {1e3 * even.step:.4g} ms: these were taken; log time with more digits, when a row is sampled",
    )
    return Series(even.time, series.columns)


def _unwrapped(series: Series, neck: Neck, path: str | Path) -> Series:
    """Motor angles without the wraps of their counters, with a warning; Refused where they wrap too fast to tell."""
    columns, said = dict(series.columns), []
    for j, motor in enumerate(neck.motors):
        name = f"theta{j + 1}"
        counter = unwrapped(columns[name], motor)
        if counter.ambiguous:
            raise Refused(
                path,
                f"{name} seems to wrap around every {counter.period:.6g}, and moves by more than a quarter of that "
                "from row to row, so that nobody can tell how often",
                "log every control step, or a counter that does not wrap",
            )
        if counter.wraps:
            said.append(f"{name} every {counter.period:.6g}, at {counter.wraps} rows")
            columns[name] = counter.values
    if said:
        warn_recovered(path, f"counters that wrap around were unwrapped: {'; '.join(said)}")
    return Series(series.time, columns)


def _from_reset_on(series: Series, path: str | Path) -> Series:
    """The rows from where counters were set, with a warning about those before."""
    row = row_of_reset(series.time, series.matrix("theta"))
    if not row:
        return series
    before, after = series.columns["theta1"][row - 1 : row + 1]
    warn_recovered(
        path,
        f"all motors leap within one row, theta1 from {before:.6g} to {after:.6g} at {series.time[row]:.3f} s, as no motor does: "
        f"their counters were set there; left out: {counted(row, 'row')} before; record once the drives have found their zeros",
    )
    return series.part(slice(row, None))


def _without_absurd_samples(series: Series, path: str | Path) -> Series:
    """The rows in which no angle and no force is absurd, with a warning about the others."""
    absurd, said = np.zeros(len(series), dtype=bool), []
    for stem, min_range in (("theta", THETA_OUTLIER_RANGE), ("f", F_OUTLIER_RANGE)):
        for j, values in enumerate(series.matrix(stem).T):
            of_column = absurd_samples(values, min_range)
            if of_column.any():
                row = int(np.argmax(of_column))
                said.append(
                    f"{stem}{j + 1} in {int(of_column.sum())} (the first is {values[row]:g} at {series.time[row]:.3f} s)"
                )
                absurd |= of_column
    if not said:
        return series
    warn_recovered(path, f"samples were left out that their neighbours contradict: {', '.join(said)}")
    return series.part(~absurd)


def uniformly_sampled(log: Series) -> Series:
    """The log at equal steps, as `at_even_times` has it."""
    return at_even_times(log, *even_times(log))


def even_times(log: Series) -> tuple[Array, float]:
    """Times from the first row to the last, (T,), s, evenly apart by about the log's step, and that step, s."""
    step, span = sampling_step(log.time, "log"), log.time[-1] - log.time[0]
    count = round(span / step) + 1
    return log.time[0] + np.arange(count) * span / (count - 1), step


def at_even_times(log: Series, time: Array, step: float) -> Series:
    """A log at times (T,) that are `step` s apart, where its rows are missing or late.

    Angles go by cubics: between two rows of a slow log they are beside the chord by more than a camera tells. Forces are the means
    of what was held. All else goes by straight lines."""
    columns = {}
    for name, values in log.columns.items():
        if name.startswith("theta") and len(log.time) >= 4:
            columns[name] = _by_cubics(time, log, name, step)
        elif name[0] == "f" and name[1:].isdigit():
            columns[name] = _held_means(time, log.time, values, step)
        else:
            columns[name] = np.interp(time, log.time, values)
    return Series(time, columns)


def _held_means(time: Array, at: Array, values: Array, step: float) -> Array:
    """Means from each of even times to the next of what holds from its row on; over missing rows it goes straight to the next."""
    lasts = np.append(np.diff(at), step)
    # rows after one that is late come when they should; where rows are missing what they held lies between
    delay = (at - at[0]) / step - np.arange(len(at))
    later = [np.append(delay[k:], np.full(k, np.inf)) for k in range(1, min(_ROWS_LATE, len(at) - 1) + 1)]
    ahead = np.min(later, axis=0) if later else delay
    are_missing = (ahead - delay > _MISSED_ROWS) & np.isfinite(ahead)
    over = np.where(are_missing, (values + np.append(values[1:], values[-1])) / 2, values)
    edges = np.append(time, time[-1] + (time[-1] - time[-2] if len(time) > 1 else step))
    # what has added up goes straight from row to row
    sums = np.interp(
        edges, np.append(at, max(at[-1] + step, edges[-1])), np.append(0.0, np.cumsum((over - over[0]) * lasts))
    )
    means = over[0] + np.diff(sums) / np.diff(edges)  # a constant stays one to the last bit
    return np.clip(means, over.min(), over.max())  # but for rounding they are within


def _by_cubics(time: Array, log: Series, name: str, step: float) -> Array:
    """Through the two rows before each time and the two behind; by a straight line where rows are missing there."""
    pieces = np.array_split(time, -(-len(time) // _ROWS_AT_ONCE))
    return np.concatenate([_piece_by_cubics(piece, log.time, log.columns[name], step) for piece in pieces])


def _piece_by_cubics(time: Array, at: Array, values: Array, step: float) -> Array:
    first = np.clip(np.searchsorted(at, time, side="right") - 2, 0, len(at) - 4)
    before = values[first + 1]  # what rests does so to the last bit
    out = before.copy()
    for i in range(4):
        others = [first + k for k in range(4) if k != i]
        weight = np.prod([(time - at[k]) / (at[first + i] - at[k]) for k in others], axis=0)
        out += weight * (values[first + i] - before)
    complete = at[first + 3] - at[first] < _MAX_CUBIC_STEPS * step
    return np.where(complete, out, np.interp(time, at, values))
