"""python -m benchmarks.wrong_logs: docs/logs.md's table of wrong and unusual logs, with the sentence that each gets."""

import re
import sys
import tempfile
from pathlib import Path

from samples.worlds.wrong_log import Outcome, WrongLog, outcome_of
from samples.worlds.wrong_logs import WRONG_LOGS

PAGE = Path(__file__).parents[1] / "docs/logs.md"
BEGIN, END = "<!--wrong logs-->\n", "<!--end of wrong logs-->"
KINDS = {"counter": "samples", "header": "CSV", "topics": "MCAP", "rate": "log", "camera": "angles"}
"""kinds whose name alone does not say what it is that is wrong"""


def main() -> int:
    """Runs every one of them through `sync`; 1 where one ends otherwise than it must."""
    rows, failed = [], 0
    for wrong in WRONG_LOGS:
        with tempfile.TemporaryDirectory() as folder:
            outcome = outcome_of(wrong, Path(folder))
        failed += outcome.ends != wrong.ends or not re.search(wrong.words, outcome.sentence)
        rows.append(
            f"| {KINDS.get(wrong.kind, wrong.kind)} {wrong.what} | {outcome.ends} | {_sentence(wrong, outcome)} |"
        )
        print(rows[-1], flush=True)
    table = "\n".join(["| log | it is | with the words |", "|---|---|---|", *rows])
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}{table}\n{END}{rest.split(END)[1]}", encoding="utf-8")
    return 1 if failed else 0


def _sentence(wrong: WrongLog, outcome: Outcome) -> str:
    """What the user is told, with the clock's error where there is a clock."""
    text = outcome.sentence.replace("|", "\\|").replace("\t", "⇥")
    if outcome.clock_error_s is None:
        return text
    return f"{text}; clock {1e3 * outcome.clock_error_s:+.2f} ms off, sigma {1e3 * outcome.clock_sigma_s:.2f} ms"


if __name__ == "__main__":
    sys.exit(main())
