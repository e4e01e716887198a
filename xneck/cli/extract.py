"""xneck extract: the joint angles of an arm, or without an arm the markers of anyone's video."""

from math import degrees, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click
from click.core import ParameterSource

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import export_beside, export_option, progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, NECK_OUTPUT, OUTPUT_FILE
from xneck_foundation.one_line import counted

if TYPE_CHECKING:
    from vision.shutter import Shutter

_MAX_GAPS = 10
"""gaps that are listed on the terminal; --json has all"""


_ARM_ONLY = ("overlay", "light", "placement", "corrected_neck")
"""options that mean nothing without an arm"""


@click.command(
    epilog="Example: xneck extract video.mp4 --camera camera.yaml --neck neck.yaml --out angles.mcap; "
    "without an arm: xneck extract video.mp4 --dictionary aruco_4x4_50 --out markers.csv"
)
@click.argument("video", type=INPUT_FILE)
@click.option(
    "--camera", "camera_file", type=INPUT_FILE, help="camera.yaml of the camera at the video's size; an arm needs it."
)
@click.option("--neck", "neck_file", type=INPUT_FILE, help="neck.yaml with the arm's markers.")
@click.option(
    "--dictionary", help="Without an arm: all markers of this dictionary, each one's corners and turn in the picture."
)
@click.option("--out", type=OUTPUT_FILE, required=True, help="angles.mcap, or .csv, .npz, .mat; markers.mcap alike.")
@click.option("--overlay", type=OUTPUT_FILE, help="A video with what was found drawn over it.")
@click.option("--exposure", type=FiniteRange(0, 1), default=0.0, help="Exposure time, s, where it is known.")
@click.option(
    "--row-time", type=FiniteRange(-1e-3, 1e-3), default=0.0, help="Rolling shutter: s from one row to the next below."
)
@click.option(
    "--stamp",
    type=click.Choice(["start", "middle", "end"]),
    default="middle",
    show_default=True,
    help="What the frames' stamps mean: begin, middle or end of the exposure.",
)
@click.option(
    "--corners",
    type=click.Choice(["template", "edges"]),
    default="template",
    show_default=True,
    help="Markers' corners from all their grey levels, or from the edges of their squares (less precise, a third faster).",
)
@click.option(
    "--light",
    type=click.IntRange(0),
    nargs=4,
    metavar="X Y WIDTH HEIGHT",
    help="Rectangle (px) with a light that the controller switches and logs as `led`.",
)
@click.option("--placement", is_flag=True, help="Estimate from the motion where each marker sits on its bar.")
@click.option("--corrected-neck", type=NECK_OUTPUT, help="Write neck.yaml with the markers where they were found.")
@click.option(
    "--workers", type=click.IntRange(1, 1024), default=1, show_default=True, help="Processes that share the video."
)
@export_option
@result_options
def command(
    video: Path,
    camera_file: Path | None,
    neck_file: Path | None,
    dictionary: str | None,
    out: Path,
    overlay: Path | None,
    exposure: float,
    row_time: float,
    stamp: Literal["start", "middle", "end"],
    corners: Literal["template", "edges"],
    light: tuple[int, int, int, int] | None,
    placement: bool,
    corrected_neck: Path | None,
    workers: int,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Joint angles alpha_1..N of every frame of a recorded video, with their standard deviations; or, with --dictionary in place of
    --neck, the markers of any video."""
    if (neck_file is None) == (dictionary is None):
        raise click.UsageError("give --neck neck.yaml for an arm's angles, or --dictionary NAME for the markers alone")
    from vision.shutter import Shutter

    shutter = Shutter(exposure, row_time, stamp)
    if dictionary is not None:
        _refuse_options_of_an_arm()
        _markers_alone(video, dictionary, camera_file, out, shutter, corners, workers, export_as, json_out, quiet)
        return
    if camera_file is None or neck_file is None:
        raise click.UsageError("an arm's angles need --camera camera.yaml")
    from calibration.camera_file import read_camera
    from mechanism.description import read_neck
    from mechanism.neck_text import neck_text
    from synchronisation.angles import write_angles
    from vision.extract import ExtractionOptions, extract
    from vision.light_patch import LightPatch
    from vision.linkage.shared_fit import PlacementPrior
    from vision.overlay_video import write_overlay
    from vision.video import describe_video
    from xneck_foundation.provenance import note_inputs, provenance
    from xneck_foundation.whole_file import write_text

    inputs = note_inputs({"video": video, "camera": camera_file, "neck": neck_file})
    camera, neck = read_camera(camera_file), read_neck(neck_file)
    options = ExtractionOptions(
        shutter=shutter,
        placement=PlacementPrior() if placement or corrected_neck else None,
        template=corners == "template",
        light=LightPatch(*light) if light else None,
    )
    described = describe_video(video)
    with progress_bar(described.frames, "extract", quiet) as done:
        extraction = extract(described, camera, neck, options, workers, done)
    angles = extraction.angles
    angles.notes["provenance"] = provenance(inputs)
    write_angles(angles, out, extraction.quality)
    export_beside(angles.series, out, export_as)
    if overlay:
        with progress_bar(len(angles.time), "overlay", quiet) as done:
            write_overlay(described, overlay, neck, camera, extraction, done)
    if corrected_neck and extraction.fit.placement:
        write_text(corrected_neck, neck_text(extraction.fit.placement.neck, f"markers as found in {video.name}"))
    result = extraction.as_json()
    report_result(result, _summary(out, result), json_out, quiet)


def _refuse_options_of_an_arm() -> None:
    ctx = click.get_current_context()
    for param in ctx.command.params:
        given = param.name in _ARM_ONLY and ctx.get_parameter_source(param.name) is not ParameterSource.DEFAULT
        if given:
            raise click.UsageError(f"{param.opts[0]} needs an arm: give --neck and --camera in place of --dictionary")


def _markers_alone(
    video: Path,
    dictionary: str,
    camera_file: Path | None,
    out: Path,
    shutter: "Shutter",
    corners: str,
    workers: int,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Corners and turns of all markers of a dictionary."""
    from calibration.camera_file import read_camera
    from vision.marker_tracks import TracksOptions, track_markers, write_tracks
    from vision.video import describe_video
    from xneck_foundation.provenance import note_inputs, provenance

    inputs = note_inputs({"video": video} | ({"camera": camera_file} if camera_file else {}))
    camera = read_camera(camera_file) if camera_file else None
    described = describe_video(video)
    options = TracksOptions(dictionary, shutter, corners == "template")
    with progress_bar(described.frames, "extract", quiet) as done:
        tracks = track_markers(described, options, camera, workers, done)
    result = tracks.as_json() | {"dictionary": dictionary, "warnings": [*described.warnings, *tracks.warnings]}
    write_tracks(tracks, out, result | {"provenance": provenance(inputs)})
    export_beside(tracks.series, out, export_as)
    lines = [f"{out}: {len(tracks.ids)} markers of {dictionary} in {len(tracks.time)} frames"]
    lines += [f"  {_marker_line(marker)}" for marker in result["markers"]]
    lines += [f"  {warning}" for warning in result["warnings"]]
    report_result(result, "\n".join(lines), json_out, quiet)


def _marker_line(marker: dict[str, Any]) -> str:
    """One marker: how often it was seen, and how well."""
    line = f"id {marker['id']}: seen in {100 * marker['seen_share']:.1f} %"
    if marker["sigma_turn_median_rad"] is not None:
        line += f", turn to {degrees(marker['sigma_turn_median_rad']):.3f} deg"
        line += f", corners to {marker['sigma_px_median']:.3f} px (one sigma)"
    return line + _twice_in_view(marker)


def _twice_in_view(marker: dict[str, Any]) -> str:
    """That a marker was left out where it was in view twice; empty where it never was."""
    if not marker["duplicates"]:
        return ""
    return f" (twice in view in {counted(marker['duplicates'], 'frame')}, left out there)"


def _summary(out: Path, result: dict[str, Any]) -> str:
    """The extraction in lines for a terminal."""
    median = result["sigma_alpha_median_rad"]
    sigma_deg = degrees(median) if median else nan
    shares = ", ".join(f"id {m['id']} {100 * m['seen_share']:.1f} %{_twice_in_view(m)}" for m in result["markers"])
    lines = [
        f"{out}: {result['frames_with_all_angles']} of {result['frames']} frames with all angles, "
        f"sigma {sigma_deg:.3f} deg, corners {result['corner_sigma_px']:.3f} px",
        f"  markers seen: {shares}",
    ]
    lines += [
        f"  {', '.join(gap['angles'])} missing {gap['from_s']:.2f} to {gap['to_s']:.2f} s: {gap['cause']}"
        for gap in result["gaps"][:_MAX_GAPS]
    ]
    lines += [f"  {warning}" for warning in result["warnings"]]
    lines += [f"  {drift['sentence']}" for drift in result["drift"]]
    lines += [f"  {_placement_line(number)}" for number in result["placement"] or []]
    return "\n".join(lines)


def _placement_line(number: dict[str, Any]) -> str:
    """One number of the placement against neck.yaml, in mm or degrees."""
    scale, unit = (1e3, "mm") if number["unit"] == "m" else (57.29578, "deg")
    offset = scale * (number["value"] - number["nominal"])
    return (
        f"{number['where']}: {number['name']} {offset:+.3f} +- {scale * number['sigma']:.3f} {unit}, {number['word']}"
    )
