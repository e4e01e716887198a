"""xneck check."""

from pathlib import Path

import click

from vision.cli.output import FILE, report_result, results


@click.command(epilog="Example: xneck check dataset.mcap --json check.json")
@click.argument("dataset", type=FILE)
@results
def command(dataset: Path, json_out: str | None, quiet: bool) -> None:
    """Hold the elongation of every cable against the force on its motor, and say whether they agree."""
    from identification.dataset_file import read_dataset
    from vision.check import check_elongations

    data = read_dataset(dataset)
    found = check_elongations(data.arm, data.state, data.state.matrix("sigma_alpha"))
    lines = [f"{dataset}: {found.verdict}"]
    lines += [
        f"  cable {c.cable}: elongation {1e3 * c.elongation_mean:.2f} +- {1e3 * c.elongation_rms:.2f} mm, "
        f"unexplained {1e3 * c.unexplained_rms:.3f} mm (vision alone {1e3 * c.expected_rms:.3f}), "
        f"compliance {1e6 * c.compliance:.1f} +- {1e6 * c.compliance_sigma:.1f} um/N"
        for c in found.cables
    ]
    lines += [f"  {f['fault']} at {f['where']}: {f['size']:.3g} {f['unit']}" for f in found.faults]
    report_result(found.as_json(), "\n".join(lines), json_out, quiet)
