"""python -m benchmarks.readme_picture [--out FILE]: the README's picture, from the sample by the real pipeline.

Left: a frame of samples/recording with the fitted linkage drawn on it. Right: what the equations of motion leave before and after
the diagnosed cause is in the model.
"""

import argparse
import io
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import xneck
from mechanism.description import read_neck
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck.recording.drawn_video import draw_video
from xneck.recording.recording_folder import read_recording
from xneck.recording.stages import recording_angles
from xneck.report import style
from xneck_foundation.provenance import note_inputs, provenance
from xneck_foundation.strict_yaml import read_text

ROOT = Path(__file__).parents[1]
PICTURE = ROOT / "docs/images/sample.png"
_DPI = 130
_SIZE_IN = (8.4, 3.9)
_MARGIN = 0.1
"""of the markers' height, above and below them"""
_ASPECT = 1.05
"""width over height of the frame that is shown"""
_LEVEL_STEP = 6.0
"""grey levels that are drawn as one"""
_BEFORE, _AFTER = style.MODELS[3], style.MODELS[1]

Picture = NDArray[np.uint8]


def main(words: Sequence[str]) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.readme_picture", description=__doc__)
    parser.add_argument("--out", type=Path, default=PICTURE, help="PNG (default: docs/images/sample.png)")
    parser.add_argument("--samples", type=Path, default=ROOT / "samples", help="folder with recording/ and held_out/")
    chosen = parser.parse_args(words)
    frame, diagnosis = measured(chosen.samples)
    png = drawn(frame, diagnosis)
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    chosen.out.write_bytes(png)
    print(f"{chosen.out}: {len(png) / 1000:.0f} kB")
    return 0


def measured(samples: Path) -> tuple[Picture, dict[str, Any]]:
    """The frame in which the arm is bent most, annotated (BGR), and the record of the diagnosis."""
    recording = read_recording(samples / "recording")
    inputs = note_inputs(recording.files)
    neck = read_neck(recording.neck)
    angles, video = recording_angles(recording, neck)
    assert video is not None
    bend = np.abs(angles.alpha).sum(axis=1)
    assert recording.video is not None
    drawn_video = draw_video(recording.video, neck, video)
    frame = max(drawn_video.frames, key=lambda frame: bend[frame.index])
    log = read_log(recording.log, neck)
    fitted = synchronise(neck, read_text(recording.neck), angles, log, provenance(inputs))
    held_out = xneck.synchronise(samples / "held_out")
    record = xneck.as_record(xneck.diagnose([fitted], [held_out]))
    return _cut_to_markers(frame.picture, video.extraction.corners[frame.index]), record


def _cut_to_markers(frame: Picture, corners: NDArray[np.float64]) -> Picture:
    """The part of the frame around all markers, corners of shape (markers, 4, 2), px."""
    visible = corners[~np.isnan(corners).any(axis=-1)]
    low, high = visible.min(axis=0), visible.max(axis=0)
    middle, half_height = (low + high) / 2, (0.5 + _MARGIN) * (high - low)[1]
    half = np.array([_ASPECT * half_height, half_height])
    left, top = np.maximum(middle - half, 0).astype(int).tolist()
    right, bottom = np.minimum(middle + half, frame.shape[1::-1]).astype(int).tolist()
    return np.ascontiguousarray(frame[top:bottom, left:right])


def drawn(frame: Picture, diagnosis: Mapping[str, Any]) -> bytes:
    """The picture as a PNG."""
    photograph_width = _photograph_width(frame)
    left = photograph_width + 0.085
    with style.drawing():
        figure = Figure(figsize=_SIZE_IN, dpi=_DPI)
        photograph = figure.add_axes((0.0, 0.0, photograph_width, 1.0))
        photograph.imshow(_few_grey_levels(frame)[:, :, ::-1], interpolation="antialiased")
        photograph.axis("off")
        _over_time(figure.add_axes((left, 0.58, 0.985 - left, 0.30)), diagnosis)
        _every_equation(figure.add_axes((left, 0.13, 0.985 - left, 0.27)), diagnosis)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png")
    return buffer.getvalue()


def _photograph_width(frame: Picture) -> float:
    """Share of the picture's width that the frame takes at full height, at most a half."""
    height, width = frame.shape[:2]
    return min(0.5, width / height * _SIZE_IN[1] / _SIZE_IN[0])


def _over_time(axes: Axes, diagnosis: Mapping[str, Any]) -> None:
    """RMS residual of the joint that stands highest above noise, in windows of the recording that was fitted."""
    joints = [c for c in diagnosis["channels"] if c["unit"] == "N m"]
    worst = max(joints, key=lambda c: c["before"] / c["noise_floor"])["channel"]
    course = diagnosis["signature"]["over_time"][0]
    (rms,) = (c for c in course["channels"] if c["channel"] == worst)
    time = np.array(course["from_s"]) + course["window_s"] / 2
    axes.fill_between(time, 0, 1e3 * np.array(rms["noise_rms"]), color=style.UNDERLAY, linewidth=0)
    axes.plot(time, 1e3 * np.array(rms["before_rms"]), color=_BEFORE)
    axes.plot(time, 1e3 * np.array(rms["after_rms"]), color=_AFTER)
    axes.set(title=f"Residual torque of {worst}, mN m", xlabel="time, s", xlim=(time[0], time[-1]), ylim=(0, None))


def _every_equation(axes: Axes, diagnosis: Mapping[str, Any]) -> None:
    """RMS residual of every equation in units of its noise floor, with the legend of both panels."""
    channels = diagnosis["channels"]
    at = np.arange(len(channels))
    for shift, key, colour, label in (
        (-0.2, "before", _BEFORE, "base model"),
        (0.2, "after", _AFTER, "with the cause"),
    ):
        ratio = [c[key] / c["noise_floor"] for c in channels]
        axes.bar(at + shift, np.maximum(ratio, 1) - 1 + 0.02, 0.38, bottom=1, color=colour, label=label)
    axes.axhline(1, color=style.MUTED, linewidth=2, label="noise alone")
    axes.set_yscale("log")
    axes.set_yticks([1, 10, 100], ["1", "10", "100"])
    axes.set_xticks(at, [c["channel"].replace(" ", "\n") for c in channels])
    axes.tick_params(axis="x", length=0, labelsize=7.0)
    axes.grid(visible=False, axis="x")
    axes.set_title("Residual of every equation, times noise")
    handles, labels = axes.get_legend_handles_labels()
    axes.figure.legend(
        handles, labels, loc="upper right", ncols=3, frameon=False, bbox_to_anchor=(0.99, 1.0), fontsize=7.5
    )


def _few_grey_levels(frame: Picture) -> Picture:
    """The frame with its noise smoothed and its levels rounded, so that the file stays small."""
    smooth = cv2.bilateralFilter(frame, 5, 20, 3)
    return (np.round(smooth / _LEVEL_STEP) * _LEVEL_STEP).clip(0, 255).astype(np.uint8)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
