"""The cases of a study on the workers, without those that are done."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from xneck.batch.worker_pool import run_tasks
from xneck.study.plan import Case
from xneck.study.run_case import run_case
from xneck_foundation.json_text import read_record

if TYPE_CHECKING:
    from distributed import Client


def cases_to_run(cases: Sequence[Case], folder: Path, code: str) -> tuple[Case, ...]:
    """The cases without a record in `folder` that the same code has written."""
    return tuple(case for case in cases if (record := stored_record(case, folder)) is None or record["code"] != code)


def stored_record(case: Case, folder: Path) -> dict[str, Any] | None:
    """The record of a case in `folder`, or None where there is none as a study wrote it."""
    try:
        return read_record(folder / f"{case.name}.json")
    except (OSError, ValueError):
        return None


def run_cases(
    client: "Client",
    cases: Sequence[Case],
    samples: Path,
    folder: Path,
    code: str,
    keep: bool,
    progress: Callable[[int], object],
) -> dict[str, str]:
    """Runs cases and returns why some of them failed, by name; `progress` is called with 1 as each ends."""
    tasks = {case.name: (case, samples, folder, code, keep) for case in cases}
    failed: dict[str, str] = {}
    for outcome in run_tasks(client, run_case, tasks):
        progress(1)
        if outcome.failure is not None:
            failed[outcome.name] = outcome.failure
    return failed
