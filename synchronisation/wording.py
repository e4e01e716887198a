"""A data set in words: its clocks, and what was said of its log."""

from identification.dataset.dataset import DataSet


def as_text(data: DataSet) -> str:
    """Clocks, rows, frames and verdict, and what was noticed on the way, a line each."""
    clock, rows = data.clock, f"{len(data.state)} samples"
    if "offset_s" not in clock:
        return f"{rows}; no clock of frames"
    text = (
        f"log = camera + {clock['offset_s']:.5f} s +- {1e3 * clock['offset_sigma_s']:.2f} ms, "
        f"skew {clock['skew_ppm']:.0f} +- {clock['skew_sigma_ppm']:.0f} ppm; {rows}, "
        f"{clock['frames_dropped']} frames dropped, {clock['log_rows_missing']} log rows missing; {data.check['verdict']}\n"
        f"  from {clock['source']}"
    )
    if clock["force_delay_s"] is not None:
        text += f"; forces act {1e3 * clock['force_delay_s']:.2f} +- {1e3 * clock['force_delay_sigma_s']:.2f} ms after their row"
    text += f"; {clock['frames_lost']} frames lost without a trace" if clock["frames_lost"] else ""
    text += f"; {clock['log_rows_held']} log rows repeated" if clock["log_rows_held"] else ""
    return text + "".join(f"\n  {warning}" for warning in clock["warnings"])
