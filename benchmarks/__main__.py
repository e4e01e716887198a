"""python -m benchmarks [NAME...] [--out FOLDER] [--again]: what xneck's parts do beside their peers, as one table.

Writes benchmarks.json and benchmarks.html into the folder after every topic. A topic that was measured there before is not measured
again while sources, sample and machine are the same. `python -m benchmarks.figures --benchmarks FOLDER` then takes the figures into
the record, and writes them into README, docs and benchmarks/results.md.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks import summary
from benchmarks.page import write_page
from benchmarks.run import TopicOutcome, run, still_valid
from benchmarks.topic import table_of
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import write_text

TOPICS = {
    name: f"benchmarks.{name}"
    for name in (
        "extraction",
        "markers",
        "hard",
        "planes",
        "real_markers",
        "calibration",
        "clock",
        "lost_frames",
        "state",
        "budget",
        "check",
        "identification",
        "laws",
        "simulation",
        "simulation_error",
        "observer",
        "observer_effects",
        "growth",
        "verdict_time",
        "clean_arms",
        "hidden_by_noise",
        "ladder",
        "reliability",
        "deciding_motions",
    )
}


def main(words: Sequence[str], topics: Mapping[str, str] = TOPICS) -> int:
    """Command line of the benchmarks; 1 where a topic failed."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(topics)}; all by default")
    parser.add_argument("--out", type=Path, default=Path("out/benchmarks"), help="folder (default: %(default)s)")
    parser.add_argument("--again", action="store_true", help="measure anew what was measured before")
    chosen = parser.parse_args(words)
    unknown = [name for name in chosen.names if name not in topics]
    if unknown:
        parser.error(f"there is no topic {unknown[0]}; there are {', '.join(topics)}")
    command = " ".join(["python -m benchmarks", *words])
    outcomes = still_valid(topics, chosen.out)
    wanted = {name: topics[name] for name in chosen.names or topics}
    try:
        for outcome in run(wanted, chosen.out, chosen.again):
            outcomes[outcome.name] = outcome
            print(_outcome_text(outcome), end="\n\n", flush=True)
            _write([outcomes[name] for name in topics if name in outcomes], topics, command, chosen.out)
    except KeyboardInterrupt:
        print("benchmarks: interrupted; what is done is kept", file=sys.stderr)
        return 130
    shown = [outcomes[name] for name in topics if name in outcomes]
    print(summary.text(shown), chosen.out / "benchmarks.html", sep="\n\n")
    return 1 if any(outcome.failure for outcome in shown) else 0


def _outcome_text(outcome: TopicOutcome) -> str:
    if outcome.record is None:
        return f"{outcome.name}: FAILED, {outcome.failure}"
    text = table_of(outcome.record).text()
    return f"{text}\n(measured before, {outcome.record['date']})" if outcome.measured_before else text


def _write(outcomes: Sequence[TopicOutcome], topics: Mapping[str, str], command: str, folder: Path) -> None:
    done = {outcome.name for outcome in outcomes}
    record = {"command": command, "not_run": [name for name in topics if name not in done]} | summary.as_json(outcomes)
    write_text(folder / "benchmarks.json", json_text(record))
    write_page(outcomes, record["not_run"], command, folder / "benchmarks.html")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
