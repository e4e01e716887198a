"""One case: files from the generator, through the steps that the commands take, to a record beside its truth."""

import json
import shutil
import time
from itertools import pairwise
from pathlib import Path
from types import ModuleType
from typing import Any

from diagnosis import record
from diagnosis.diagnose import diagnose
from identification.dataset.dataset_file import read_dataset, write_dataset
from mechanism.description import read_neck
from synchronisation.angles import read_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck.recording.recording_folder import read_recording
from xneck.study.generator import generator
from xneck.study.plan import Case
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import as_json
from xneck_foundation.provenance import provenance
from xneck_foundation.strict_yaml import read_text
from xneck_foundation.whole_file import write_text


def run_case(case: Case, samples: Path, folder: Path, code: str, keep: bool) -> None:
    """Writes folder/NAME.json, whole; folder/NAME holds the recordings and data sets meanwhile, and after if `keep`.

    What `sync` or `diagnose` refuse is a result too. Raises ValueError where the generator finds no motion for the case.
    """
    here = folder / case.name
    try:
        result = {"name": case.name, "case": case.as_json(), "code": code, **_outcome(case, generator(samples), here)}
        write_text(folder / f"{case.name}.json", as_json(result))
    finally:
        if not keep and here.exists():
            shutil.rmtree(here)


def _outcome(case: Case, experiment: ModuleType, here: Path) -> dict[str, Any]:
    """The truth, and the diagnosis with the clocks' records or why it was refused."""
    took = [time.monotonic()]
    experiment.hide(
        case.kinds,
        case.seed,
        here,
        seconds=case.seconds,
        noise_deg=case.noise_deg,
        manner=case.manner,
        size=case.size,
    )
    took.append(time.monotonic())
    outcome: dict[str, Any]
    try:
        clocks = {name: _sync(here / name, here / f"{name}.mcap") for name in experiment.RECORDINGS}
        took.append(time.monotonic())
        fitted, held_out = (read_dataset(here / f"{name}.mcap") for name in experiment.RECORDINGS)
        outcome = {"diagnosis": record.as_json(diagnose([fitted], [held_out])), "clocks": clocks}
    except Refused as refusal:
        outcome = {"refused": str(refusal).replace(f"{here}/", "")}
    took.append(time.monotonic())
    truth = json.loads((here / "truth.json").read_text(encoding="utf-8"))
    return {"truth": truth, **outcome, "steps_s": [round(b - a, 2) for a, b in pairwise(took)]}


def _sync(folder: Path, out: Path) -> dict[str, Any]:
    """A recording folder to a data set, and the record of its clock."""
    recording = read_recording(folder)
    assert recording.angles is not None
    neck = read_neck(recording.neck)
    angles, log = read_angles(recording.angles, neck.N), read_log(recording.log, neck)
    origin = provenance({"angles": recording.angles, "log": recording.log, "neck": recording.neck})
    data = synchronise(neck, read_text(recording.neck), angles, log, origin)
    write_dataset(data, out)
    return dict(data.clock)
