"""xneck identify."""

from pathlib import Path

import click

from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, MODEL_OUTPUT, NECK_OUTPUT

IDENTIFIED_S, IDENTIFIED_STRETCHES = 300.0, 5
"""s of a recording that are identified, and number of stretches where it is longer (docs/thresholds.md)"""
MAX_HELD_S = 600.0
"""s of all recordings together that are identified (docs/thresholds.md)"""


@click.command(epilog="Example: xneck identify dataset.mcap --out model.yaml --json identified.json")
@click.argument("datasets", metavar="DATASET...", nargs=-1, required=True, type=INPUT_FILE)
@click.option("--out", type=MODEL_OUTPUT, required=True, help="model.yaml, which `xneck simulate` takes.")
@click.option(
    "--model", type=click.IntRange(1, 3), default=1, show_default=True, help="Elastic model of Fasquelle 2021."
)
@click.option("--export", "export_as", type=click.Choice(["mat"]), help="The parameters beside --out as arrays.")
@click.option(
    "--neck-out", type=NECK_OUTPUT, help="neck.yaml with the pre-elongations x0 as identified, of one data set."
)
@click.option(
    "--laws-of",
    type=INPUT_FILE,
    help="A model.yaml with laws that `xneck diagnose` found: their amounts are identified too, their inner constants stay.",
)
@result_options
def command(
    datasets: tuple[Path, ...],
    out: Path,
    model: int,
    laws_of: Path | None,
    export_as: str | None,
    neck_out: Path | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Identify friction of the motors and elasticity of the cables: estimates that hold, and beside them Fasquelle's tables."""
    from identification import estimate_table
    from identification.dataset.stretches import chosen_stretches, read_stretches
    from identification.estimates import LAWS_BY_ELASTIC_MODEL, estimate
    from identification.fasquelle import tables
    from identification.fasquelle.method import fasquelle_identification
    from identification.model_file import read_model, unlisted_laws_of, write_model
    from identification.parameters_file import write_mat, write_neck
    from identification.pose_calibration import calibrated_model
    from xneck_foundation.errors import Refused
    from xneck_foundation.provenance import note_inputs, provenance

    found = {"laws_of": laws_of} if laws_of else {}
    inputs = note_inputs({f"dataset{i + 1}": path for i, path in enumerate(datasets)} | found)
    judged = chosen_stretches(datasets, IDENTIFIED_S, IDENTIFIED_STRETCHES, MAX_HELD_S)
    if neck_out and not all(one.whole for one in judged):
        raise Refused(
            neck_out, f"x0 is of one recording of at most {IDENTIFIED_S:.0f} s", "record a shorter one for it"
        )
    recordings = [data for path, one in zip(datasets, judged, strict=True) for data in read_stretches(path, one)]
    fasquelle = fasquelle_identification(recordings)
    laws, held = unlisted_laws_of(read_model(laws_of)) if laws_of else ((), {})
    estimates = estimate(recordings, (*LAWS_BY_ELASTIC_MODEL[model], *laws), held)
    origin = provenance(inputs, {"model": model})
    found_model = estimates.model.model_copy(update={"provenance": origin})
    posed = calibrated_model(found_model, recordings)
    write_model(posed.model, out)
    if export_as:
        write_mat(estimates.parameters, estimates.laws, out.with_suffix(f".{export_as}"))
    if neck_out:
        write_neck(recordings[0].neck, estimates.parameters, ", ".join(path.name for path in datasets), neck_out)
    record = estimates.as_json() | {"fasquelle": tables.as_json(fasquelle, model)}
    record["pose"] = posed.as_json()
    record["judged"] = [one.record for one in judged]
    text = f"{estimate_table.as_text(estimates)}\n\n{tables.as_text(fasquelle)}\n{out}{posed.as_text()}"
    text += "".join(f"\n{path}: {one.text}" for path, one in zip(datasets, judged, strict=True) if not one.whole)
    report_result(record, text, json_out, quiet)
