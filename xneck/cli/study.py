"""xneck study."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from xneck.cli.cluster_options import worker_options
from xneck.cli.demo import SAMPLES_FOLDER
from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import progress_bar, report_result, result_options
from xneck.cli.path_types import FOLDER, OutputFolder
from xneck.cli.terminal import print_error
from xneck.recording.result_files import CASES_FOLDER, STUDY_FILES, STUDY_RECORD, STUDY_TABLES

if TYPE_CHECKING:
    from xneck.batch.cluster import Cluster

_MANNERS = ("rich", "slow", "constant tension")


@click.command(
    epilog="Example: xneck study --out study --effects none,tip_payload,cable_slack --seeds 5 --size 0.2 1 --pairs 10"
)
@click.option(
    "--out",
    type=OutputFolder(STUDY_FILES),
    default=Path("study"),
    show_default=True,
    help="Folder for study.md, study.json and cases/.",
)
@click.option(
    "--effects",
    multiple=True,
    default=("all",),
    show_default=True,
    help="What to hide: all (none included), catalogue, outside, none, names, several at once with +; commas between.",
)
@click.option(
    "--seeds", type=click.IntRange(0, 1_000_000), default=10, show_default=True, help="Arms, each with all --effects."
)
@click.option("--first-seed", type=click.IntRange(0), default=100, show_default=True, help="Seed of the first arm.")
@click.option(
    "--pairs",
    type=click.IntRange(0, 1_000_000),
    default=0,
    show_default=True,
    help="Cases more, of two effects at random.",
)
@click.option(
    "--manner", "manners", multiple=True, type=click.Choice(_MANNERS), default=("rich",), show_default=True,
    help="How the arm moves; may be repeated.",
)  # fmt: skip
@click.option(
    "--size", nargs=2, type=FiniteRange(0, 100), default=(1.0, 1.0), show_default=True, metavar="LOW HIGH",
    help="Range that sizes are drawn from; 1 is normal, 0 is nothing.",
)  # fmt: skip
@click.option(
    "--noise", "noise_deg", type=FiniteRange(0, 10), default=0.1, show_default=True, help="Of angles, degrees."
)
@click.option(
    "--seconds", nargs=2, type=FiniteRange(5, 3600), default=(60.0, 60.0), show_default=True, metavar="FITTED HELD_OUT",
    help="Length of the two recordings of a case.",
)  # fmt: skip
@worker_options
@click.option("--keep", is_flag=True, help="Keep each case's recordings and data sets.")
@click.option(
    "--samples", type=FOLDER, default=SAMPLES_FOLDER, help="The samples folder of a checkout.  [default: this one's]"
)
@result_options
def command(
    out: Path,
    effects: tuple[str, ...],
    seeds: int,
    first_seed: int,
    pairs: int,
    manners: tuple[str, ...],
    size: tuple[float, float],
    noise_deg: float,
    seconds: tuple[float, float],
    jobs: int | None,
    cluster: "Cluster | None",
    keep: bool,
    samples: Path,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Hide effects in generated recordings, diagnose them, and count how often they are found.

    Each case draws an arm, its errors of drawing, motions, noise and clocks from its seed, and goes through sync and diagnose.
    It is written to cases/ when it ends: what is there is not run again, unless xneck has changed since. Run the same command
    to go on.
    """
    if size[0] > size[1]:
        raise click.UsageError("--size: LOW is more than HIGH")
    from xneck.batch.worker_pool import worker_pool
    from xneck.study.generator import load_generator
    from xneck.study.plan import StudyOptions, effect_sets, planned_cases
    from xneck.study.run_cases import cases_to_run, run_cases, stored_record
    from xneck.study.study_result import StudyResult
    from xneck_foundation.errors import Refused
    from xneck_foundation.folder_lock import only_run_in
    from xneck_foundation.source_digest import source_digest
    from xneck_foundation.whole_file import check_output

    experiment = load_generator(samples)
    options = StudyOptions(
        effects=effect_sets(effects, list(experiment.KINDS), list(experiment.CATALOGUE)),
        seeds=range(first_seed, first_seed + seeds),
        pairs=pairs,
        manners=manners,
        size=size,
        noise_deg=noise_deg,
        seconds=seconds,
    )
    cases = planned_cases(options, list(experiment.CATALOGUE))
    if not cases:
        raise Refused("study", "has no case", "give --seeds or --pairs")
    samples, cases_folder = samples.resolve(), out.resolve() / CASES_FOLDER
    code = source_digest(samples / "generator")
    with only_run_in(out):
        cases_folder.mkdir(exist_ok=True)
        for file in (STUDY_TABLES, STUDY_RECORD):
            check_output(out / file)
        pending = cases_to_run(cases, cases_folder, code)
        failed: dict[str, str] = {}
        if pending:
            with worker_pool(jobs, cluster, cases_folder) as client, progress_bar(len(pending), "study", quiet) as step:
                failed = run_cases(client, pending, samples, cases_folder, code, keep, step)
        records = [r for case in cases if (r := stored_record(case, cases_folder)) is not None and r["code"] == code]
        failures = [f"{name} failed: {reason}" for name, reason in failed.items()]
        if not records:
            raise Refused("study", f"no case came to an end; {failures[0]}")
        for line in failures:
            print_error(f"warning: {line}")
        done_before = len(records) - len(pending) + len(failed)
        settings = options.as_json() | {"code": code}
        result = StudyResult.of(records, list(experiment.KINDS), settings, failed, done_before)
        result.write_files(out)
    report_result(result.as_json(), f"{result.text()}; {out}", json_out, quiet)
