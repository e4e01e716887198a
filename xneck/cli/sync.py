"""xneck sync."""

from pathlib import Path

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import export_beside, export_option, progress_bar, recovered, report_result, result_options
from xneck.cli.path_types import DATA_SET_OUTPUT, INPUT_FILE


@click.command(epilog="Example: xneck sync angles.mcap log.mcap --neck neck.yaml --out dataset.mcap")
@click.argument("angles_file", metavar="ANGLES", type=INPUT_FILE)
@click.argument("log_file", metavar="LOG", type=INPUT_FILE)
@click.option("--neck", "neck_file", type=INPUT_FILE, required=True, help="neck.yaml of the arm.")
@click.option("--out", type=DATA_SET_OUTPUT, required=True, help="dataset.mcap.")
@click.option("--cutoff", type=FiniteRange(0.5, 15), default=5.0, show_default=True, help="Hz, of Fasquelle's filter.")
@export_option
@result_options
def command(
    angles_file: Path,
    log_file: Path,
    neck_file: Path,
    out: Path,
    cutoff: float,
    export_as: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Align camera and log clocks, and write the data set: state at the log's rate and at Fasquelle's 31.25 Hz.

    ANGLES is angles.mcap or a CSV with time,alpha1..alphaN[,sigma1..sigmaN] in rad; LOG an MCAP with JointState or a CSV
    with time,theta1..thetaM,f1..fM.
    """
    from identification.dataset.dataset_file import write_dataset
    from mechanism.description import read_neck
    from synchronisation.angles import read_angles
    from synchronisation.encoder_log import read_log
    from synchronisation.long.synchronise_parts import is_long, steps_of, synchronise_parts
    from synchronisation.synchronise import synchronise
    from synchronisation.wording import as_text
    from xneck_foundation.errors import Refused
    from xneck_foundation.provenance import note_inputs, provenance
    from xneck_foundation.strict_yaml import read_text

    inputs = note_inputs({"angles": angles_file, "log": log_file, "neck": neck_file})
    neck = read_neck(neck_file)
    angles, log = read_angles(angles_file, neck.N), read_log(log_file, neck)
    origin = provenance(inputs, {"cutoff_hz": cutoff})
    origin["recovered"] = recovered()
    text = read_text(neck_file)
    if is_long(log):
        if export_as in ("npz", "mat"):
            raise Refused(out, f"a recording of this length is not exported as {export_as}", "export csv, or cut it")
        with progress_bar(steps_of(angles), "sync", quiet) as done:
            data = synchronise_parts(neck, text, angles, log, origin, out.parent, cutoff, done)
    else:
        data = synchronise(neck, text, angles, log, origin, cutoff)
    write_dataset(data, out)
    export_beside(data.state, out, export_as)
    report_result(dict(data.clock), f"{out}: {as_text(data)}", json_out, quiet)
