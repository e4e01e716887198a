"""xneck calibrate."""

from pathlib import Path

import click

from vision.cli.output import FILE, OUT, progress, report_result, results


@click.command(epilog="Example: xneck calibrate board/*.jpg --board board.yaml --out camera.yaml")
@click.argument("sources", metavar="PICTURES... | VIDEO", nargs=-1, required=True, type=FILE)
@click.option("--board", "board_file", type=FILE, required=True, help="board.yaml: what is printed on the board.")
@click.option("--out", type=OUT, required=True, help="camera.yaml, as ROS and OpenCV read it.")
@click.option("--every", type=click.IntRange(1), default=5, show_default=True, help="Take every n-th frame of a video.")
@results
def command(
    sources: tuple[Path, ...], board_file: Path, out: Path, every: int, json_out: str | None, quiet: bool
) -> None:
    """Calibrate the camera from pictures of a board (files or a folder), or from a video of it.

    Pictures that disagree are left out and named. Refused where the pictures cannot tell the camera.
    """
    from calibration.camera_file import write_camera
    from calibration.summary import as_json
    from vision.calibrating import calibrate_from, listed

    files = listed(sources)
    with progress(None if len(files) == 1 else len(files), "calibrate", quiet) as done:
        found = calibrate_from(files, board_file, every, done)
    write_camera(found.camera, out)
    result = as_json(found)
    lines = [f"{out}: reprojection {found.rms_px:.3f} px, held out {found.held_out_rms_px:.3f} px"]
    lines += [
        f"  {p['name']:3} {p['value']:12.5g} {'+-' if p['sigma'] is not None else 'fixed'} {p['sigma'] or 0:.2g} {p['unit']}"
        for p in result["parameters"]
    ]
    lines += [f"  left out: {p['file']}: {p['why']}" for p in result["pictures"] if not p["used"]]
    lines += [f"  note: {note}" for note in result["notes"]]
    report_result(result, "\n".join(lines), json_out, quiet)
