"""xneck logs."""

from pathlib import Path

import click

from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, NECK_OUTPUT


@click.command(epilog="Example: xneck logs controller.csv --neck neck.yaml --out mapped.yaml")
@click.argument("log_file", metavar="LOG", type=INPUT_FILE)
@click.option("--neck", "neck_file", type=INPUT_FILE, help="neck.yaml of the arm, whose motors are looked for.")
@click.option("--out", type=NECK_OUTPUT, help="A new neck.yaml, that of --neck with the mapping in it.")
@result_options
def command(log_file: Path, neck_file: Path | None, out: Path | None, json_out: Path | None, quiet: bool) -> None:
    """Say what is in a log, and how neck.yaml must map it: CSV, Parquet, MCAP, or a ROS bag (.bag, .db3).

    Names and values tell which columns or joints are the motors' angles and forces, and in which units. What they do not tell is
    said, and `xneck sync` checks all of it against the video. Without --out nothing is written.
    """
    from mechanism.description import Motor, read_neck
    from mechanism.neck_template import MOTOR
    from mechanism.neck_text import neck_text
    from synchronisation.log_contents import read_contents
    from synchronisation.log_mapping import map_log, mapped_neck, neck_keys, scales_rest_on
    from synchronisation.log_words import contents_lines, mapping_lines, mapping_record, snippet
    from xneck_foundation.whole_file import write_text

    if out is not None and neck_file is None:
        raise click.UsageError(
            "--out needs --neck: it is that description with the mapping; or begin one: xneck init --log"
        )
    neck = read_neck(neck_file) if neck_file else None
    contents = read_contents(log_file)
    mapping = map_log(log_file, contents, neck.M if neck else None)
    described = neck.motors if neck else [Motor.model_validate(MOTOR)] * mapping.motors
    log, motors = neck_keys(mapping, described)
    lines = [*contents_lines(log_file, contents), *mapping_lines(mapping), "in neck.yaml:", snippet(log, motors)]
    if neck is None:
        lines.append(
            f"scales are those of an example motor (R {MOTOR['R']:g}, rd {MOTOR['rd']:g} m); give --neck for yours"
        )
    if neck is not None and out is not None:
        rests_on = scales_rest_on(mapping, neck.motors)
        comment = ". ".join(filter(None, [f"{neck_file} with the columns of {log_file.name}", rests_on]))
        write_text(out, neck_text(mapped_neck(neck, mapping), comment))
        lines.append(f"{out}: {neck_file} with this mapping" + (f". {rests_on}" if rests_on else ""))
    record = mapping_record(contents, mapping, log, motors) | {"out": str(out) if out else None}
    report_result(record, "\n".join(lines), json_out, quiet)
