"""xneck study."""

from pathlib import Path

import click

from xneck.cli.demo import SAMPLES
from xneck.cli.output import FOLDER, progress, report_result, results, spreading

_MANNERS = ("rich", "slow", "constant tension")


@click.command(
    epilog="Example: xneck study --out study --effects none,tip_payload,cable_slack --seeds 5 --size 0.2 1 --pairs 10"
)
@click.option(
    "--out", type=FOLDER, default=Path("study"), show_default=True, help="Folder for study.md, study.json and cases/."
)
@click.option(
    "--effects",
    multiple=True,
    default=("all",),
    show_default=True,
    help="What to hide: all (none included), catalogue, outside, none, names, several at once with +; commas between.",
)
@click.option("--seeds", type=click.IntRange(0), default=10, show_default=True, help="Arms, each with all --effects.")
@click.option("--first-seed", type=click.IntRange(0), default=100, show_default=True, help="Seed of the first arm.")
@click.option(
    "--pairs", type=click.IntRange(0), default=0, show_default=True, help="Cases more, of two effects at random."
)
@click.option(
    "--manner", "manners", multiple=True, type=click.Choice(_MANNERS), default=("rich",), show_default=True,
    help="How the arm moves; may be repeated.",
)  # fmt: skip
@click.option(
    "--size", nargs=2, type=click.FloatRange(0), default=(1.0, 1.0), show_default=True, metavar="LOW HIGH",
    help="Range that sizes are drawn from; 1 is normal, 0 is nothing.",
)  # fmt: skip
@click.option(
    "--noise", "noise_deg", type=click.FloatRange(0), default=0.1, show_default=True, help="Of angles, degrees."
)
@click.option(
    "--seconds", nargs=2, type=click.FloatRange(5), default=(60.0, 60.0), show_default=True, metavar="FITTED HELD_OUT",
    help="Length of the two recordings of a case.",
)  # fmt: skip
@spreading
@click.option("--keep", is_flag=True, help="Keep each case's recordings and data sets.")
@click.option(
    "--samples", type=FOLDER, default=SAMPLES, help="The samples folder of a checkout.  [default: this one's]"
)
@results
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
    cluster: str | None,
    keep: bool,
    samples: Path,
    json_out: str | None,
    quiet: bool,
) -> None:
    """Hide effects in generated recordings, diagnose them, and count how often they are found.

    Each case draws an arm, its errors of drawing, motions, noise and clocks from its seed, and goes through sync and diagnose.
    It is written to cases/ when it ends: what is there is not run again, unless xneck has changed since. Run the same command
    to go on.
    """
    if size[0] > size[1]:
        raise click.UsageError("--size: LOW is more than HIGH")
    from xneck.batch.spread import workers
    from xneck.study.generator import generator
    from xneck.study.plan import effects_of, plan
    from xneck.study.running import result_of, run_cases, undone
    from xneck.study.score import score
    from xneck.study.summary import tables
    from xneck_foundation.errors import Refused
    from xneck_foundation.json_text import as_json
    from xneck_foundation.source_digest import digest
    from xneck_foundation.whole_file import write_text

    experiment = generator(samples)
    samples, cases_in = samples.resolve(), out.resolve() / "cases"
    wanted = effects_of(effects, list(experiment.KINDS), list(experiment.CATALOGUE))
    cases = plan(
        wanted,
        pairs,
        list(experiment.CATALOGUE),
        range(first_seed, first_seed + seeds),
        manners,
        size,
        noise_deg,
        seconds,
    )
    if not cases:
        raise Refused("study", "has no case", "give --seeds or --pairs")
    cases_in.mkdir(parents=True, exist_ok=True)
    code = digest(samples / "generator")
    left = undone(cases, cases_in, code)
    failed: dict[str, str] = {}
    if left:
        with workers(jobs, cluster, cases_in) as client, progress(len(left), "study", quiet) as step:
            failed = run_cases(client, left, samples, cases_in, code, keep, step)
    done = [r for case in cases if (r := result_of(case, cases_in)) is not None and r["code"] == code]
    lost = [f"{name} failed: {why}" for name, why in failed.items()]
    if not done:
        raise Refused("study", f"no case came to an end; {lost[0]}")
    for line in lost:
        click.echo(f"xneck: warning: {line}", err=True)
    scores = [score(r) for r in done]
    found = tables(scores, list(experiment.KINDS))
    summary = f"{len(done)} cases, {len(done) - len(left) + len(failed)} of them done before; {len(failed)} failed"
    settings = {
        "effects": ["+".join(kinds) or "none" for kinds in wanted],
        "seeds": seeds, "first_seed": first_seed, "pairs": pairs, "manners": list(manners), "size": list(size),
        "noise_deg": noise_deg, "seconds": list(seconds), "code": code,
    }  # fmt: skip
    result = {
        "settings": settings,
        "cases": len(done),
        "failed": failed,
        "tables": [table.as_json() for table in found],
        "scores": [s.as_json() for s in scores],
    }
    told = ", ".join(f"{key} {value}" for key, value in settings.items())
    failures = ["## Failed\n\n" + "\n".join(f"- {line}" for line in lost)] if lost else []
    parts = [f"# {summary}", told, *(table.markdown() for table in found), *failures]
    write_text(out / "study.md", "\n\n".join(parts) + "\n")
    write_text(out / "study.json", as_json(result))
    text = "\n\n".join([*(table.text() for table in found), f"{summary}; {out}"])
    report_result(result, text, json_out, quiet)
