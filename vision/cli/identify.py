"""xneck identify."""

from pathlib import Path

import click

from vision.cli.output import FILE, OUT, report_result, results


@click.command(epilog="Example: xneck identify dataset.mcap --out model.yaml --json identified.json")
@click.argument("datasets", metavar="DATASET...", nargs=-1, required=True, type=FILE)
@click.option("--out", type=OUT, required=True, help="model.yaml, which `xneck simulate` takes.")
@click.option("--model", type=click.IntRange(1, 3), default=1, show_default=True, help="Elastic model of the seed.")
@results
def command(datasets: tuple[Path, ...], out: Path, model: int, json_out: str | None, quiet: bool) -> None:
    """Identify dry friction, viscous friction and cable elasticity as the seed does, with relative sigmas."""
    from identification.dataset_file import read_dataset
    from identification.model import SEED_LAWS, model_of, write_model
    from identification.seed_method import identify
    from identification.tables import as_json, as_text
    from xneck.provenance import provenance

    found = identify([read_dataset(path) for path in datasets])
    fit = found.elastic[model]
    origin = provenance({f"dataset{i + 1}": path for i, path in enumerate(datasets)}, {"model": model})
    write_model(model_of(fit.parameters, SEED_LAWS[model], origin), out)
    report_result(as_json(found, model), f"{as_text(found)}\n{out}", json_out, quiet)
