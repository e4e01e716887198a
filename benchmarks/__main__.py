"""python -m benchmarks [NAME...] [--json FILE]: runs the benchmarks and prints one table a topic."""

import argparse
import json
from pathlib import Path

from benchmarks import (
    calibration,
    check,
    clock,
    extraction,
    growth,
    hard,
    identification,
    lost_frames,
    real_markers,
    simulation,
    simulation_error,
    state,
)
from benchmarks.table import Table

TOPICS = {
    "extraction": extraction.measure,
    "hard": hard.measure,
    "real_markers": real_markers.measure,
    "growth": growth.measure,
    "clock": clock.measure,
    "check": check.measure,
    "calibration": calibration.measure,
    "lost_frames": lost_frames.measure,
    "state": state.measure,
    "identification": identification.measure,
    "simulation": simulation.measure,
    "simulation_error": simulation_error.measure,
}


def main() -> None:
    """Command line of the benchmarks."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(TOPICS)}; all by default")
    parser.add_argument("--json", type=Path, help="the tables for other programs")
    chosen = parser.parse_args()
    tables: dict[str, Table] = {}
    for name in chosen.names or TOPICS:
        tables[name] = TOPICS[name]()
        print(tables[name].text(), end="\n\n", flush=True)
    if chosen.json:
        chosen.json.write_text(json.dumps({name: table.as_json() for name, table in tables.items()}, indent=2) + "\n")


if __name__ == "__main__":
    main()
