"""xneck show."""

from pathlib import Path

import click

from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE
from xneck_foundation.one_line import counted


@click.command(epilog="Example: xneck show neck.yaml --out neck.svg --alpha 20,-10,5")
@click.argument("neck_file", metavar="NECK.yaml", type=INPUT_FILE)
@click.option("--out", type=OUTPUT_FILE, required=True, help="The drawing: .svg, .png or .pdf.")
@click.option("--alpha", metavar="DEG,...", help="Joint angles from the base up, deg, or one for all.  [0: straight]")
@result_options
def command(neck_file: Path, out: Path, alpha: str | None, json_out: Path | None, quiet: bool) -> None:
    """Draw the arm from its description, to check it with one's eyes.

    Bars, diagonals, pulleys, springs, the way of each cable around its pulleys, markers with their ids, and the numbers beside.
    """
    import numpy as np

    from mechanism.arm import arm_of
    from mechanism.cable_lengths import Z, lengths
    from mechanism.description import read_neck
    from mechanism.printed_markers import marker_doubts
    from vision.markers.known_markers import known_markers
    from xneck.cli.angle_list import angle_list
    from xneck.report.arm_sheet import write_arm_sheet
    from xneck.report.description_text import route_text

    neck = read_neck(neck_file)
    warnings = list(marker_doubts(known_markers(neck, neck_file), neck.N)) if neck.markers else []
    angles = angle_list("--alpha", alpha or "0", neck.N, "deg")
    write_arm_sheet(neck, angles, out, neck_file.name)
    arm = arm_of(neck)
    straight = lengths(arm, np.zeros(neck.N))
    warnings += [
        f"cables[{j}].length is {cable.length:g} m, but the cable runs {along:.4g} m from the base up: give the whole cable's"
        for j, (cable, along) in enumerate(zip(neck.cables, straight, strict=True))
        if cable.length < along
    ]
    long, lever = lengths(arm, angles), Z(arm, angles)
    pose = f"at {alpha} deg" if angles.any() else "straight"
    counts = f"{counted(neck.N, 'mechanism')} and {counted(neck.M, 'cable')}"
    lines = [f"{out}: {counts}, drawn {pose}"]
    lines += [
        f"  cable {j + 1}: {route_text(cable.route)}; {1e3 * long[j]:.1f} mm from the base up; "
        f"lever {', '.join(f'{1e3 * arms:+.1f}' for arms in lever[:, j])} mm"
        for j, cable in enumerate(neck.cables)
    ]
    lines.append(
        "  levers are those of the cable's pull on each joint, from the base up; positive turns it counter-clockwise"
    )
    record = {"out": str(out), "alpha": angles.tolist(), "cable_length_m": long.tolist(), "Z_m": lever.tolist()}
    report_result(record | {"warnings": warnings}, "\n".join(lines), json_out, quiet, warnings)
