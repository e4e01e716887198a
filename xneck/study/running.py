"""A whole study: what is not yet done is spread over the workers, and what is there is scored."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from xneck.batch.spread import spread
from xneck.study.case import run_case
from xneck.study.plan import Case

if TYPE_CHECKING:
    from distributed import Client


def undone(cases: Sequence[Case], folder: Path, code: str) -> tuple[Case, ...]:
    """Cases of which `folder` holds no record by the same code."""
    return tuple(case for case in cases if (done := result_of(case, folder)) is None or done["code"] != code)


def result_of(case: Case, folder: Path) -> dict[str, Any] | None:
    """The record of a case, or None where there is none."""
    file = folder / f"{case.name}.json"
    return json.loads(file.read_text(encoding="utf-8")) if file.is_file() else None


def run_cases(
    client: "Client",
    cases: Sequence[Case],
    samples: Path,
    folder: Path,
    code: str,
    keep: bool,
    step: Callable[[int], object],
) -> dict[str, str]:
    """Runs cases; `step` is told of each as it ends. Returns why some of them failed, by name."""
    tasks = {case.name: (case, samples, folder, code, keep) for case in cases}
    failed: dict[str, str] = {}
    for outcome in spread(client, run_case, tasks):
        step(1)
        if outcome.failure is not None:
            failed[outcome.name] = outcome.failure
    return failed
