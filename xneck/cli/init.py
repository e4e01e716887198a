"""xneck init."""

import importlib
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, NECK_OUTPUT, OUTPUT_FILE
from xneck_foundation.errors import Refused
from xneck_foundation.one_line import counted

if TYPE_CHECKING:
    from synchronisation.log_mapping import LogMapping

_LENGTH = FiniteRange(0.001, 2)
_KINDS = {
    "neck": ("mechanism.description", "Neck"),
    "board": ("calibration.board", "Board"),
    "recording": ("xneck.recording.recording_folder", "RecordingFile"),
}
"""what a schema is of: the module that reads it, and its name there"""
_DEFAULT_MECHANISMS = 3
_MECHANISMS, _CABLES = click.IntRange(1, 100), click.IntRange(1, 200)
Number = TypeVar("Number", int, float)


@click.command(epilog="Example: xneck init --mechanisms 2 --cables 6 --out neck.yaml")
@click.option("--mechanisms", type=_MECHANISMS, help="X-joints, one upon another. [3]")
@click.option("--cables", type=_CABLES, help="Cables, each with a motor. [one more than mechanisms]")
@click.option("--L", "L", type=_LENGTH, help="m, length of the diagonal bars. [0.1]")
@click.option("--b", "b", type=_LENGTH, help="m, length of the bottom and top bars. [0.05]")
@click.option("--log", "log_file", type=INPUT_FILE, help="A log of the arm: its columns and units go into neck.yaml.")
@click.option("--out", type=NECK_OUTPUT, help="neck.yaml.")
@click.option("--schema", type=OUTPUT_FILE, help="A JSON schema for editors; neck.yaml then names it.")
@click.option(
    "--schema-of", type=click.Choice(list(_KINDS)), default="neck", show_default=True, help="Which file it describes."
)
@result_options
def command(
    mechanisms: int | None,
    cables: int | None,
    L: float | None,
    b: float | None,
    log_file: Path | None,
    out: Path | None,
    schema: Path | None,
    schema_of: str,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Write a neck.yaml to fill in: a whole arm with example numbers, a comment for every key, and usual routes.

    What is not given is asked on a terminal. Elsewhere it is 3 mechanisms, one cable more than mechanisms (or one for each motor of
    --log), L = 0.1 and b = 0.05.
    """
    if out is None and schema is None:
        raise click.UsageError("nothing to write: give --out neck.yaml, or --schema FILE for an editor")
    result: dict[str, Any] = {}
    lines, warnings = list[str](), list[str]()
    if out is not None:
        asked = sys.stdin.isatty() and sys.stdout.isatty()
        named = schema if schema_of == "neck" else None
        mapping = _mapping(log_file, cables)
        arm = _arm(asked, mechanisms, mapping.motors if mapping else cables, L, b)
        result, lines, warnings = _write_neck(out, arm, named, mapping)
    if schema is not None:
        _write_schema(schema, schema_of)
        result |= {"schema": str(schema)}
        line = f"# yaml-language-server: $schema={schema.name}"
        by = f"by the first line of {out}" if out and schema_of == "neck" else f"by a first line `{line}` in the file"
        lines.append(f"{schema}: the schema of {schema_of}.yaml; editors find it {by}")
    report_result(result, "\n".join(lines), json_out, quiet, warnings)


def _arm(
    asked: bool, mechanisms: int | None, cables: int | None, L: float | None, b: float | None
) -> tuple[int, int, float, float]:
    """What was given, and what was not as it is answered, or as it is usual."""
    from mechanism.neck_template import DEFAULT_BAR, DEFAULT_DIAGONAL

    mechanisms = mechanisms or _answer(asked, "How many mechanisms (X-joints)", _DEFAULT_MECHANISMS, _MECHANISMS)
    cables = cables or _answer(asked, "How many cables, each with a motor", mechanisms + 1, _CABLES)
    L = L or _answer(asked, "Length L of the diagonal bars, m", DEFAULT_DIAGONAL, _LENGTH)
    b = b or _answer(asked, "Length b of the bottom and top bars, m", min(DEFAULT_BAR, L / 2), _LENGTH)
    if b >= L:
        raise Refused(
            "init", f"L = {L:g} m must exceed b = {b:g} m for the diagonals to cross", "give other --L and --b"
        )
    return mechanisms, cables, L, b


def _answer(asked: bool, question: str, usual: Number, kind: click.ParamType) -> Number:
    """What a person answers on a terminal; the usual number elsewhere."""
    return click.prompt(question, default=usual, type=kind) if asked else usual


def _mapping(log_file: Path | None, cables: int | None) -> "LogMapping | None":
    """Which columns of the log are the motors'; None without one."""
    if log_file is None:
        return None
    from synchronisation.log_contents import read_contents
    from synchronisation.log_mapping import map_log

    return map_log(log_file, read_contents(log_file), cables)


def _write_neck(
    out: Path, arm: tuple[int, int, float, float], schema: Path | None, mapping: "LogMapping | None"
) -> tuple[dict[str, Any], list[str], list[str]]:
    """Writes neck.yaml, which names the schema where there is one; returns its record, its lines and warnings."""
    from identification.design.trajectory import tension_levels
    from mechanism.arm import arm_of
    from mechanism.description import Motor, Neck
    from mechanism.neck_template import MOTOR, LogKeys, neck_template
    from xneck_foundation.strict_yaml import parse_yaml, validate_document
    from xneck_foundation.whole_file import write_text

    logged, said = None, []
    if mapping is not None:
        from synchronisation.log_mapping import neck_keys
        from synchronisation.log_words import mapping_lines

        logged = LogKeys(*neck_keys(mapping, [Motor.model_validate(MOTOR)] * mapping.motors))
        said = [f"  {line}" for line in mapping_lines(mapping)]
    text = neck_template(*arm, logged)
    neck = validate_document(parse_yaml(text, "init"), Neck, "init", "give other --L and --b")
    if schema is not None:
        text = f"# yaml-language-server: $schema={os.path.relpath(schema, out.parent)}\n{text}"
    write_text(out, text)
    counts = f"{counted(neck.N, 'mechanism')} and {counted(neck.M, 'cable')}"
    lines = [f"{out}: {counts}, with example numbers: put in yours"]
    lines += [f"  cable {j + 1}: {', '.join(cable.route)}" for j, cable in enumerate(neck.cables)]
    lines += said
    lines.append(f"  then look at it: xneck show {out} --out {out.with_suffix('.svg')}")
    record = {"out": str(out), "mechanisms": neck.N, "cables": neck.M, "routes": [c.route for c in neck.cables]}
    warnings = []
    try:
        tension_levels(arm_of(neck))
    except Refused as refusal:
        warnings.append(f"{out}: {refusal.what}; {refusal.do}")
    return record | {"warnings": warnings}, lines, warnings


def _write_schema(schema: Path, schema_of: str) -> None:
    from xneck_foundation.json_schema import json_schema
    from xneck_foundation.json_text import json_text
    from xneck_foundation.whole_file import write_text

    module, name = _KINDS[schema_of]
    kind = getattr(importlib.import_module(module), name)
    write_text(schema, json_text(json_schema(kind, f"{schema_of}.yaml")))
