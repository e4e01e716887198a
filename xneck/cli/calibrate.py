"""xneck calibrate."""

from pathlib import Path
from typing import Any, Literal

import click

from xneck.cli.output import INPUT_FILE, OUTPUT_FILE, progress_bar, report_result, result_options

EXAMPLES = """\b
Example: xneck calibrate board/*.jpg --board board.yaml --out camera.yaml
  xneck calibrate board/ --board board.yaml --out camera.yaml --neck neck.yaml --report calibration.html
  xneck calibrate board/ --board board.yaml --out camera.yaml --export kalibr
  xneck calibrate monday/ --board board.yaml --check camera.yaml
"""


@click.command(epilog=EXAMPLES)
@click.argument("sources", metavar="PICTURES... | VIDEO", nargs=-1, required=True, type=INPUT_FILE)
@click.option("--board", "board_file", type=INPUT_FILE, required=True, help="board.yaml: what is printed on the board.")
@click.option("--out", type=OUTPUT_FILE, help="camera.yaml, as ROS and OpenCV read it.")
@click.option("--every", type=click.IntRange(1), default=5, show_default=True, help="Take every n-th frame of a video.")
@click.option(
    "--check",
    "checked",
    type=INPUT_FILE,
    help="Instead of --out: does this camera still hold for the pictures? (also OpenCV's or Kalibr's file)",
)
@click.option(
    "--export",
    "export_as",
    type=click.Choice(["opencv", "kalibr"]),
    help="The camera for other tools too, beside --out: camera.opencv.yaml or camera.kalibr.yaml.",
)
@click.option("--report", type=OUTPUT_FILE, help="An HTML page of the calibration: what it means, what to photograph next.")
@click.option("--neck", "neck_file", type=INPUT_FILE, help="neck.yaml: say what sigma does to this arm's joint angles.")
@click.option("--link", type=click.FloatRange(0.001, 10), help="The same for two links of this length, m.")
@click.option(
    "--distance", type=click.FloatRange(0.01, 100), help="Of the arm, m; without it the arm fills the picture."
)
@result_options
def command(
    sources: tuple[Path, ...],
    board_file: Path,
    out: Path | None,
    every: int,
    checked: Path | None,
    export_as: Literal["opencv", "kalibr"] | None,
    report: Path | None,
    neck_file: Path | None,
    link: float | None,
    distance: float | None,
    json_out: str | None,
    quiet: bool,
) -> None:
    """Calibrate the camera from pictures of a board (files or a folder), or from a video of it.

    Pictures that disagree are left out and named. Refused where the pictures cannot tell the camera. With --check nothing is
    calibrated: the verdict is `holds`, `does not hold` or `cannot tell` (exit status 0, the verdict is in --json).
    """
    if checked is not None:
        given = {"--out": out, "--export": export_as, "--report": report, "--neck": neck_file, "--link": link}
        also = [name for name, value in {**given, "--distance": distance}.items() if value is not None]
        if also:
            raise click.UsageError(f"--check writes no camera and goes without {', '.join(also)}")
        _check(sources, board_file, every, checked, json_out, quiet)
        return
    if out is None:
        raise click.UsageError("give --out camera.yaml, or --check camera.yaml")
    if neck_file is not None and link is not None:
        raise click.UsageError("--neck and --link are two arms: give one")
    if distance is not None and neck_file is None and link is None:
        raise click.UsageError("--distance is that of an arm: give --neck or --link too")
    _calibrate(sources, board_file, out, every, export_as, report, neck_file, link, distance, json_out, quiet)


def _calibrate(
    sources: tuple[Path, ...],
    board_file: Path,
    out: Path,
    every: int,
    export_as: Literal["opencv", "kalibr"] | None,
    report: Path | None,
    neck_file: Path | None,
    link: float | None,
    distance: float | None,
    json_out: str | None,
    quiet: bool,
) -> None:
    from calibration.board import read_board
    from calibration.calibration_quality import assess_quality
    from calibration.camera_file import export_camera, write_camera
    from calibration.summary import calibration_json
    from mechanism.description import read_neck
    from vision.linkage.arm_sigma import arm_sigma, marker_arm, two_link_arm
    from xneck.recording.calibration_input import calibrate_from_files, list_board_files
    from xneck_foundation.provenance import provenance

    files = list_board_files(sources)
    arm = marker_arm(read_neck(neck_file), neck_file.name) if neck_file else two_link_arm(link) if link else None
    with progress_bar(None if len(files) == 1 else len(files), "calibrate", quiet) as done:
        found = calibrate_from_files(files, board_file, every, done)
    write_camera(found.camera, out)
    meant = assess_quality(found)
    at_arm = arm_sigma(found.camera, arm, distance) if arm else None
    result = calibration_json(found) | meant.as_json()
    result["projection"]["arm"] = at_arm.as_json() if at_arm else None
    if report:
        from xneck.report.calibration_page import CalibrationResult, write_calibration_report

        inputs = {"board": board_file} | ({"neck": neck_file} if neck_file else {})
        inputs |= {f"picture {file.name}": file for file in files}
        whole = CalibrationResult(out.name, read_board(board_file).title, found, meant, at_arm, provenance(inputs))
        write_calibration_report(whole, report)
    lines = [f"{out}: reprojection {found.rms_px:.3f} px, held out {found.held_out_rms_px:.3f} px"]
    lines += [
        f"  {p['name']:3} {p['value']:12.5g} {'+-' if p['sigma'] is not None else 'fixed'} {p['sigma'] or 0:.2g} {p['unit']}"
        for p in result["parameters"]
    ]
    projection = meant.projection
    lines.append(
        f"  known to {projection.median:.2g} px over the picture, {projection.worst:.2g} px in the {projection.worst_place}"
    )
    if at_arm:
        lines.append(
            f"  at the arm ({at_arm.name}, {at_arm.distance:.2f} m): {at_arm.px:.2g} px, {at_arm.mm:.2g} mm, "
            f"{57.29578 * at_arm.worst_alpha:.2g} deg of a joint angle"
        )
    lines += [f"  left out: {p['file']}: {p['why']}" for p in result["pictures"] if not p["used"]]
    lines += [f"  note: {note}" for note in result["notes"]]
    lines += [f"  next: {p.words} (sigma -{100 * p.reduction:.0f} %)" for p in meant.next_pictures[:1]]
    lines += [f"  {report}" for _ in range(report is not None)]
    if export_as:
        path, lost = export_camera(found.camera, out, export_as)
        lines.append(f"  {path}" + (f": {lost}" if lost else ""))
    report_result(result, "\n".join(lines), json_out, quiet)


def _check(
    sources: tuple[Path, ...], board_file: Path, every: int, checked: Path, json_out: str | None, quiet: bool
) -> None:
    from calibration.camera_check import check_camera
    from calibration.camera_file import read_camera
    from xneck.recording.calibration_input import list_board_files, observe_board_files

    camera = read_camera(checked)
    files = list_board_files(sources)
    with progress_bar(None if len(files) == 1 else len(files), "check", quiet) as done:
        found = check_camera(camera, observe_board_files(files, board_file, every, done))
    result: dict[str, Any] = found.as_json()
    lines = [f"{checked}: {found.verdict}: {found.why}"]
    lines += [f"  left out: {entry.name}: {entry.why}" for entry in found.left_out]
    lines += [f"  note: {note}" for note in found.notes]
    report_result(result, "\n".join(lines), json_out, quiet)
