"""xneck board."""

from pathlib import Path

import click

from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE


@click.command(epilog="Example: xneck board board.yaml --out board.pdf")
@click.argument("source", metavar="BOARD.yaml|NECK.yaml", type=INPUT_FILE)
@click.option("--out", type=OUTPUT_FILE, required=True, help="The sheet: .pdf or .svg.")
@result_options
def command(source: Path, out: Path, json_out: Path | None, quiet: bool) -> None:
    """Print a calibration board, or the markers of an arm, at true scale with a ruler to check it."""
    from calibration.board import read_board
    from calibration.sheets import board_sheet, marker_sheet
    from mechanism.description import read_neck
    from mechanism.printed_markers import marker_doubts
    from vision.markers.known_markers import known_markers
    from xneck_foundation.errors import Refused
    from xneck_foundation.strict_yaml import load_yaml
    from xneck_foundation.yaml_kinds import yaml_kind_of

    document, warnings = load_yaml(source), list[str]()
    if isinstance(document, dict) and "kind" in document:
        width, height = board_sheet(read_board(source), out)
        what = "board"
    elif isinstance(document, dict) and "mechanisms" in document:
        neck = read_neck(source)
        markers = known_markers(neck, source)
        warnings = list(marker_doubts(markers, neck.N))
        ids = [marker.id for marker in markers.on_bars]
        sheets, (width, height) = marker_sheet(ids, markers.size, markers.dictionary, out, source.stem)
        what = f"{len(ids)} markers, {sheets} sheet{'s' * (sheets > 1)}"
    else:
        known = yaml_kind_of(document) if isinstance(document, dict) else None
        found = f"{known.name} ({known.file}), " if known else ""
        raise Refused(source, f"is {found}neither a board.yaml (key `kind`) nor a neck.yaml (key `mechanisms`)")
    text = (
        f"{out}: {what} on {width:.0f} x {height:.0f} mm. "
        "Print at 100 % (no fitting to the page) and measure the ruler."
    )
    record = {"out": str(out), "width_mm": width, "height_mm": height, "warnings": warnings}
    report_result(record, text, json_out, quiet, warnings)
