"""How often causes are true that are named with some probability, over all runs of the ladder."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from benchmarks.figures.rate import Rate
from benchmarks.forward_arm_runs import Record, percent, topic_folder
from benchmarks.ladder import NOISES_DEG, SEEDS, hidden_in, judged, runs_in
from benchmarks.table import Table

EDGES = (0.0, 0.4, 0.6, 0.8, 0.99, 1.01)
"""of the bins of probability; a cause that nothing looks like has 1"""


def measure(seeds: Sequence[int] = SEEDS, noises: Sequence[float] = NOISES_DEG, folder: Path | None = None) -> Table:
    """By bins of the probability that was stated; a name is true where it was hidden in the arm."""
    runs = runs_in(folder or topic_folder("ladder"), seeds, noises)
    for _ in runs.complete(judged):
        pass
    return table([record for scene in runs.scenes for noise in runs.noises for record in runs.done(scene, noise)])


def table(records: Sequence[Record]) -> Table:
    """Of records of the ladder."""
    named = [
        (probability, name in hidden_in(record["scene"], record))
        for record in records
        for name, probability in zip(record.get("causes", ()), record.get("probabilities", ()), strict=True)
    ]
    rows = []
    for low, high in pairwise(EDGES):
        true = [is_true for probability, is_true in named if low <= probability < high]
        stated = [probability for probability, _ in named if low <= probability < high]
        if true:
            mean = 100 * sum(stated) / len(stated)
            rows.append(
                (
                    f"{100 * low:.0f} to {min(100.0, 100 * high):.0f} %",
                    (len(true), mean, *percent(Rate(sum(true), len(true)))),
                )
            )
    columns = ("names", "stated, %", "true, %", "95 % from", "to")
    return Table("Causes that are named with some probability", columns, tuple(rows))
