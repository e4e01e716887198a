"""xneck extract."""

from pathlib import Path
from typing import Literal

import click

from vision.cli.output import FILE, OUT, export_beside, exported, progress, report_result, results


@click.command(epilog="Example: xneck extract video.mp4 --camera camera.yaml --neck neck.yaml --out angles.mcap")
@click.argument("video", type=FILE)
@click.option(
    "--camera", "camera_file", type=FILE, required=True, help="camera.yaml of the camera at the video's size."
)
@click.option("--neck", "neck_file", type=FILE, required=True, help="neck.yaml with the arm's markers.")
@click.option("--out", type=OUT, required=True, help="angles.mcap, or .csv, .npz, .mat.")
@click.option("--overlay", type=OUT, help="A video with what was found drawn over it.")
@click.option("--exposure", type=click.FloatRange(0, 1), default=0.0, help="Exposure time, s, where it is known.")
@click.option("--row-time", type=float, default=0.0, help="Rolling shutter: s from one row to the next below.")
@click.option(
    "--stamp",
    type=click.Choice(["start", "middle", "end"]),
    default="middle",
    show_default=True,
    help="What the frames' stamps mean: begin, middle or end of the exposure.",
)
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes that share the video.")
@exported
@results
def command(
    video: Path,
    camera_file: Path,
    neck_file: Path,
    out: Path,
    overlay: Path | None,
    exposure: float,
    row_time: float,
    stamp: Literal["start", "middle", "end"],
    workers: int,
    export_as: str | None,
    json_out: str | None,
    quiet: bool,
) -> None:
    """Joint angles alpha_1..N of every frame of a recorded video, with their standard deviations."""
    import numpy as np

    from calibration.camera import read_camera
    from mechanism.description import read_neck
    from vision.angles import write_angles
    from vision.extract import extract
    from vision.overlay import write_overlay
    from vision.shutter import Shutter
    from vision.video import describe
    from xneck.provenance import provenance

    camera, neck = read_camera(camera_file), read_neck(neck_file)
    with progress(describe(video).frames, "extract", quiet) as done:
        found = extract(video, camera, neck, Shutter(exposure, row_time, stamp), workers, done)
    found.angles.notes["provenance"] = provenance({"video": video, "camera": camera_file, "neck": neck_file})
    write_angles(found.angles, out, found.quality)
    export_beside(found.angles.series, out, export_as)
    if overlay:
        with progress(len(found.angles.time), "overlay", quiet) as done:
            write_overlay(video, overlay, neck, camera, found, done)
    result = found.as_json()
    median = result["sigma_alpha_median_rad"]
    shares = ", ".join(f"id {m['id']} {100 * m['seen_share']:.1f} %" for m in found.angles.notes["markers"])
    lost = [
        f"\n  {', '.join(gap['angles'])} missing {gap['from_s']:.2f} to {gap['to_s']:.2f} s: {gap['cause']}"
        for gap in result["gaps"]
    ]
    text = (
        f"{out}: {result['frames_with_all_angles']} of {result['frames']} frames with all angles, "
        f"sigma {np.degrees(median) if median else float('nan'):.3f} deg, corners {result['corner_sigma_px']:.3f} px\n"
        f"  markers seen: {shares}"
    )
    report_result(result, text + "".join(lost[:10]), json_out, quiet)
