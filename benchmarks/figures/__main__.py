"""python -m benchmarks.figures [--study PATH...] [--benchmarks PATH] [--check]: the figures of README and docs, from real runs.

Without options it writes every page's figures anew from the records in benchmarks/record and from the catalogue of effects.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.figures import benchmark_record, study_record
from benchmarks.figures.benchmark_figures import benchmark_figures
from benchmarks.figures.catalogue import catalogue_figures
from benchmarks.figures.pages import ROOT, filled, pages
from benchmarks.figures.study_figures import study_figures
from benchmarks.figures.threshold_figures import threshold_figures
from benchmarks.thresholds import record as threshold_record
from benchmarks.tuned_seeds import TUNED_SEEDS


def all_figures() -> dict[str, str]:
    """Every figure by name, from the records and the catalogue."""
    return (
        catalogue_figures()
        | study_figures(study_record.read_record(), TUNED_SEEDS)
        | benchmark_figures(benchmark_record.read_record())
        | threshold_figures(threshold_record.read_record())
    )


def main(words: Sequence[str]) -> int:
    """Command line; with --check 1 where a page differs."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.figures", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--study", nargs="+", type=Path, metavar="PATH", default=[],
        help="study.json files, their folders, or folders of cases; together they replace the record of studies",
    )  # fmt: skip
    parser.add_argument(
        "--benchmarks", type=Path, metavar="PATH",
        help="benchmarks.json of `python -m benchmarks`, or its folder; its topics replace those of the record",
    )  # fmt: skip
    parser.add_argument("--check", action="store_true", help="change no page, and name those that differ")
    chosen = parser.parse_args(words)
    if chosen.study:
        study_record.write_record(study_record.imported(chosen.study))
    if chosen.benchmarks:
        benchmark_record.write_record(benchmark_record.imported(chosen.benchmarks, benchmark_record.read_record()))
    figures = all_figures()
    changed = [page for page in pages() if filled(text := page.read_text(encoding="utf-8"), figures) != text]
    for page in changed:
        print(f"{page.relative_to(ROOT)}: {'differs from the records' if chosen.check else 'written'}")
        if not chosen.check:
            page.write_text(filled(page.read_text(encoding="utf-8"), figures), encoding="utf-8")
    return 1 if chosen.check and changed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
