"""xneck check."""

from pathlib import Path

import click

from xneck.cli.output import progress_bar, report_result, result_options
from xneck.cli.path_types import INPUT_FILE


@click.command(epilog="Example: xneck check today.mcap --baseline healthy.mcap --json check.json")
@click.argument("dataset", type=INPUT_FILE)
@click.option(
    "--baseline",
    type=INPUT_FILE,
    help="A data set of the same arm, recorded when it was known to be healthy, theta counted from the same zero: "
    "shows constant errors of an angle ten times smaller.",
)
@result_options
def command(dataset: Path, baseline: Path | None, json_out: Path | None, quiet: bool) -> None:
    """Hold the elongation of every cable against the force on its motor, and name the fault where they do not agree.

    A fault comes with its size, sigma and place, the others that would look the same, and what to do about it.
    """
    from identification.dataset.stretches import parts_of
    from synchronisation.check.checked_parts import OVERLAP_S, merged_checks
    from synchronisation.check.from_dataset import check_dataset

    healthy = next(parts_of(baseline)) if baseline else None
    checks = []
    with progress_bar(None, "check", quiet) as done:
        for part in parts_of(dataset, overlap=OVERLAP_S):
            checks.append(check_dataset(part, healthy, str(baseline)))
            done(1)
    check = merged_checks(checks)
    report_result(check.as_json(), f"{dataset}: {check.as_text()}", json_out, quiet)
