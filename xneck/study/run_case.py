"""One case of a study: recordings from the generator, synchronised and diagnosed, and the record beside the truth."""

import glob
import json
import shutil
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

from diagnosis import record
from diagnosis.diagnose import diagnose
from identification.dataset.dataset_file import read_dataset, write_dataset
from xneck.recording.stages import synchronise_recording
from xneck.study.generator import load_generator
from xneck.study.plan import Case
from xneck_foundation.authorship import written_by_xneck
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.whole_file import check_output, replaces_any_file, write_text

_CASE = "case.json"
"""what was asked for, in the folder of a case: such a folder is a study's"""


@one_blas_thread
def run_case(case: Case, samples: Path, folder: Path, code: str, keep: bool) -> None:
    """Writes folder/NAME.json, whole, and with `keep` folder/NAME with the recordings and data sets, before it.

    A case that `sync` or `diagnose` refuses has a record too. Raises Refused where a file or folder is there that no study made,
    ValueError where the generator finds no motion for the case.
    """
    record_file, kept = folder / f"{case.name}.json", folder / case.name
    check_output(record_file)
    if keep and kept.exists() and not written_by_xneck(kept / _CASE) and not replaces_any_file():
        raise Refused(kept, "exists, and no study made it", "remove it, or give --force")
    for abandoned in folder.glob(f".{glob.escape(case.name)}.xneck-????????"):
        shutil.rmtree(abandoned, ignore_errors=True)
    work = Path(tempfile.mkdtemp(prefix=f".{case.name}.xneck-", dir=folder))
    try:
        write_text(work / _CASE, json_text(case.as_json()))
        outcome = _outcome(case, load_generator(samples), work)
        result = {"name": case.name, "case": case.as_json(), "code": code, **outcome}
        if keep:
            if kept.exists():
                shutil.rmtree(kept)
            work.rename(kept)
        write_text(record_file, json_text(result))
    finally:
        shutil.rmtree(work, ignore_errors=True)


def _outcome(case: Case, experiment: ModuleType, folder: Path) -> dict[str, Any]:
    """The truth, the diagnosis with the clocks' records or why it was refused, and the time that each step took."""
    instants = [time.monotonic()]
    experiment.hide(
        case.kinds,
        case.seed,
        folder,
        seconds=case.seconds,
        noise_deg=case.noise_deg,
        manner=case.manner,
        size=case.size,
    )
    instants.append(time.monotonic())
    outcome: dict[str, Any]
    try:
        clocks = {name: _sync(folder / name, folder / f"{name}.mcap") for name in experiment.RECORDINGS}
        instants.append(time.monotonic())
        fitted, held_out = (read_dataset(folder / f"{name}.mcap") for name in experiment.RECORDINGS)
        outcome = {"diagnosis": record.as_json(diagnose([fitted], [held_out])), "clocks": clocks}
    except Refused as refusal:
        outcome = {"refused": str(refusal).replace(f"{folder}/", "")}
    instants.append(time.monotonic())
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    return {"truth": truth, **outcome, "steps_s": [round(b - a, 2) for a, b in pairwise(instants)]}


def _sync(folder: Path, out: Path) -> dict[str, Any]:
    """Writes the data set of a recording folder and returns the record of its clock."""
    data = synchronise_recording(folder)
    write_dataset(data, out)
    return dict(data.clock)
