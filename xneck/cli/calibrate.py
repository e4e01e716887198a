"""xneck calibrate."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from xneck.cli.files_apart import writes_also
from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE
from xneck_foundation.unit_text import with_unit

if TYPE_CHECKING:
    from calibration.calibration_quality import CalibrationQuality
    from calibration.camera import Camera
    from vision.linkage.arm_sigma import ArmSigma

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
@click.option(
    "--report", type=OUTPUT_FILE, help="An HTML page of the calibration: what it means, what to photograph next."
)
@click.option("--neck", "neck_file", type=INPUT_FILE, help="neck.yaml: say what sigma does to this arm's joint angles.")
@click.option("--link", type=FiniteRange(0.001, 10), help="The same for two links of this length, m.")
@click.option("--distance", type=FiniteRange(0.01, 100), help="Of the arm, m; without it the arm fills the picture.")
@result_options
@writes_also(lambda options: _written_beside(options["out"], options["report"], options["export_as"]))
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
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Calibrate the camera from pictures of a board (files or a folder), or from a video of it.

    Pictures that disagree are left out and named. Refused where the pictures cannot tell the camera. With --check nothing is
    calibrated: the verdict is `holds`, `does not hold` or `cannot tell` (exit status 0, the verdict is in --json).
    """
    if checked is not None:
        options = {"--out": out, "--export": export_as, "--report": report, "--neck": neck_file, "--link": link}
        conflicting = [name for name, value in {**options, "--distance": distance}.items() if value is not None]
        if conflicting:
            raise click.UsageError(f"--check writes no camera and goes without {', '.join(conflicting)}")
        _check(sources, board_file, every, checked, json_out, quiet)
        return
    if out is None:
        raise click.UsageError("give --out camera.yaml, or --check camera.yaml")
    if neck_file is not None and link is not None:
        raise click.UsageError("--neck and --link are two arms: give one")
    if distance is not None and neck_file is None and link is None:
        raise click.UsageError("--distance is that of an arm: give --neck or --link too")
    files = _Inputs(sources, board_file, every)
    arm = _Arm(neck_file, link, distance)
    _calibrate(files, arm, out, report, export_as, json_out, quiet)


def _written_beside(out: Path | None, report: Path | None, export_as: str | None) -> dict[str, Path | None]:
    """The files that `calibrate` writes beside those that are named, by the option that asks for them."""
    from calibration.camera_file import export_path
    from xneck.report.figures_file import figures_beside

    return {
        "--export": export_path(out, export_as) if out and export_as else None,
        "--report": figures_beside(report) if report else None,
    }


@dataclass(frozen=True)
class _Inputs:
    """What a camera is calibrated from."""

    sources: tuple[Path, ...]
    """pictures, folders of them, or one video"""
    board: Path
    every: int
    """frames of a video from one that is taken to the next"""


@dataclass(frozen=True)
class _Arm:
    """The arm for which the camera's sigma is wanted, by its neck.yaml or by two links of one length; none of both: no arm."""

    neck: Path | None
    link_m: float | None
    distance_m: float | None
    """of the arm from the camera; None: the arm fills the picture"""


def _calibrate(
    inputs: _Inputs,
    arm: _Arm,
    out: Path,
    report: Path | None,
    export_as: Literal["opencv", "kalibr"] | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Calibrates, and writes camera.yaml, the report and the camera for other tools."""
    from calibration.board import read_board
    from calibration.calibration_quality import assess_quality
    from calibration.camera_file import export_camera, write_camera
    from calibration.summary import calibration_json
    from xneck.recording.calibration_input import calibrate_from_files, list_board_files
    from xneck_foundation.provenance import note_inputs, provenance

    files = list_board_files(inputs.sources)
    one_folder = len({file.name for file in files}) == len(files)
    noted = note_inputs(
        {"board": inputs.board}
        | ({"neck": arm.neck} if arm.neck else {})
        | {f"picture {file.name if one_folder else file}": file for file in files}
    )
    with progress_bar(None if len(files) == 1 else len(files), "calibrate", quiet) as done:
        calibration = calibrate_from_files(files, inputs.board, inputs.every, done)
    origin = provenance(noted)
    write_camera(calibration.camera, out)
    quality = assess_quality(calibration)
    sigma_at_arm = _sigma_at_arm(calibration.camera, arm)
    result = calibration_json(calibration) | quality.as_json()
    result["projection"]["arm"] = sigma_at_arm.as_json() if sigma_at_arm else None
    lines = _summary_lines(out, result, quality, sigma_at_arm)
    if report:
        from xneck.report.calibration_page import CalibrationResult, write_calibration_report

        page = CalibrationResult(
            name=out.name,
            board=read_board(inputs.board).title,
            calibration=calibration,
            quality=quality,
            arm=sigma_at_arm,
            provenance=origin,
        )
        write_calibration_report(page, report)
        lines.append(f"  {report}")
    if export_as:
        path, lost = export_camera(calibration.camera, out, export_as)
        lines.append(f"  {path}" + (f": {lost}" if lost else ""))
    report_result(result, "\n".join(lines), json_out, quiet)


def _sigma_at_arm(camera: "Camera", arm: _Arm) -> "ArmSigma | None":
    """What the camera's uncertainty does to the arm's joint angles, or None where no arm is given."""
    from mechanism.description import read_neck
    from vision.linkage.arm_sigma import arm_sigma, marker_arm, two_link_arm

    if arm.neck is not None:
        return arm_sigma(camera, marker_arm(read_neck(arm.neck), arm.neck.name), arm.distance_m)
    return arm_sigma(camera, two_link_arm(arm.link_m), arm.distance_m) if arm.link_m else None


def _summary_lines(
    out: Path, result: dict[str, Any], quality: "CalibrationQuality", arm: "ArmSigma | None"
) -> list[str]:
    """The calibration in lines for a terminal, from its machine-readable `result` and what it was made from."""
    lines = [f"{out}: reprojection {result['rms_px']:.3f} px, held out {result['held_out_rms_px']:.3f} px"]
    lines += [
        f"  {p['name']:3} {p['value']:12.5g} "
        + with_unit(f"+- {p['sigma']:.2g}" if p["sigma"] is not None else "fixed", p["unit"])
        for p in result["parameters"]
    ]
    projection = quality.projection
    lines.append(
        f"  known to {projection.median:.2g} px over the picture, {projection.worst:.2g} px in the {projection.worst_place}"
    )
    if arm:
        lines.append(
            f"  at the arm ({arm.name}, {arm.distance:.2f} m): {arm.px:.2g} px, {arm.mm:.2g} mm, "
            f"{57.29578 * arm.worst_alpha:.2g} deg of a joint angle"
        )
    lines += [f"  left out: {p['file']}: {p['why']}" for p in result["pictures"] if not p["used"]]
    lines += [f"  note: {note}" for note in result["notes"]]
    lines += [f"  next: {p.words} (sigma -{100 * p.reduction:.0f} %)" for p in quality.next_pictures[:1]]
    return lines


def _check(
    sources: tuple[Path, ...], board_file: Path, every: int, checked: Path, json_out: Path | None, quiet: bool
) -> None:
    """Checks whether the camera in the file `checked` still holds for these pictures."""
    from calibration.camera_check import check_camera
    from calibration.camera_file import read_camera
    from xneck.recording.calibration_input import list_board_files, observe_board_files

    camera = read_camera(checked)
    files = list_board_files(sources)
    with progress_bar(None if len(files) == 1 else len(files), "check", quiet) as done:
        check = check_camera(camera, observe_board_files(files, board_file, every, done))
    result: dict[str, Any] = check.as_json()
    lines = [f"{checked}: {check.verdict}: {check.why}"]
    lines += [f"  left out: {entry.name}: {entry.why}" for entry in check.left_out]
    lines += [f"  note: {note}" for note in check.notes]
    report_result(result, "\n".join(lines), json_out, quiet)
