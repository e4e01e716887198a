"""xneck observe."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from identification.dataset.dataset_file import EXPORT_FORMATS
from xneck.cli.files_apart import writes_also
from xneck.cli.output import export_beside, progress_bar, recovered, report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE

_C = "c"
"""format of the observer itself"""


def _c_file(options: Mapping[str, Any]) -> Mapping[str, Path | None]:
    return {"--export c": options["out"].with_suffix(".c") if options["export_as"] == _C else None}


@click.command(epilog="Example: xneck observe log.mcap --neck neck.yaml --model model.yaml --out state.mcap")
@click.argument("log_file", metavar="LOG", type=INPUT_FILE)
@click.option("--neck", "neck_file", type=INPUT_FILE, required=True, help="neck.yaml of the arm.")
@click.option("--model", "model_file", type=INPUT_FILE, required=True, help="model.yaml of `identify` or `diagnose`.")
@click.option("--out", type=OUTPUT_FILE, required=True, help="state.mcap (also .csv, .npz, .mat).")
@click.option(
    "--angles",
    "angles_file",
    type=INPUT_FILE,
    help="Angles that a camera saw now and then: a data set, or a CSV on the log's clock.",
)
@click.option(
    "--start", metavar="RAD,...", help="Joint angles where the log begins, or one for all; found by the cables without."
)
@click.option("--smooth", is_flag=True, help="Each row by the rows after it as well.")
@click.option(
    "--export",
    "export_as",
    type=click.Choice((*EXPORT_FORMATS, _C)),
    help="The same series beside --out for other tools; c: the observer itself, for a controller.",
)
@result_options
@writes_also(_c_file)
def command(
    log_file: Path,
    neck_file: Path,
    model_file: Path,
    out: Path,
    angles_file: Path | None,
    start: str | None,
    smooth: bool,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Tell the joints from the motors alone, at the log's rate, with sigma, and whether the arm is still the one identified."""
    import numpy as np

    from identification.dataset.dataset_file import export_series
    from identification.dataset.true_rows import true_rows
    from identification.files import joint_state
    from identification.model_file import read_model
    from mechanism.description import read_neck
    from observation.c_source import c_source
    from observation.observed_log import observe_log
    from observation.observer import Observer
    from synchronisation.encoder_log import read_log
    from synchronisation.frames_on_log import read_frames_on_log
    from xneck.cli.angle_list import angle_list
    from xneck.cli.model_of_arm import warn_of_another_arm
    from xneck.export.result_words import in_words
    from xneck_foundation.errors import Refused, one_of
    from xneck_foundation.provenance import note_inputs, provenance
    from xneck_foundation.whole_file import write_text

    one_of(out, out.suffix.removeprefix(".").lower(), ("mcap", *EXPORT_FORMATS), "suffix")
    given = {"angles": angles_file} if angles_file else {}
    inputs = note_inputs({"log": log_file, "neck": neck_file, "model": model_file} | given)
    neck, model = read_neck(neck_file), read_model(model_file)
    warn_of_another_arm(model, model_file, neck, neck_file)
    log = true_rows(read_log(log_file, neck), log_file)
    frames = read_frames_on_log(angles_file, neck, log) if angles_file else None
    pose = None if start is None else angle_list("--start", start, neck.N, "rad")
    with progress_bar(len(log), "observe", quiet) as done:
        observed = observe_log(neck, model, log, frames, pose, smooth, done)
    if frames is not None and not observed.frames_used:
        raise Refused(str(angles_file), "none of its frames shows a joint within the log")
    origin = provenance(inputs, {"smooth": smooth, "start": start})
    origin["recovered"] = recovered()
    record = observed.as_json()
    if out.suffix.lower() == ".mcap":
        joint_state.write(out, {"state": observed.series}, {"provenance": origin, "observer": record})
    else:
        export_series(observed.series, out)
    if export_as == _C:
        step_s = float(np.median(np.diff(log.time)))
        write_text(out.with_suffix(".c"), c_source(Observer(neck, model, step_s)))
    else:
        export_beside(observed.series, out, export_as)
    report_result(record, f"{out}: {in_words(observed)}", json_out, quiet)
