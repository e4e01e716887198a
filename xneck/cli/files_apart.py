"""What a command writes lies apart from what it reads and from what else it writes, by whatever path or link."""

import fnmatch
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from identification.dataset.dataset_file import EXPORT_FORMATS
from xneck.cli.path_types import STANDARD_OUTPUT, JsonOutput, OutputFile, OutputFolder
from xneck_foundation.errors import Refused
from xneck_foundation.same_file import real_path, same_file
from xneck_foundation.whole_file import check_kind, check_output

Command = TypeVar("Command", bound=Callable[..., Any])
_WRITES_ALSO = "writes_also"


def writes_also(outputs: Callable[[Mapping[str, Any]], Mapping[str, Path | None]]) -> Callable[[Command], Command]:
    """Tells which files a command writes beside those that its options name: what leads to each, and the file, by its options."""

    def marked(function: Command) -> Command:
        setattr(function, _WRITES_ALSO, outputs)
        return function

    return marked


def outputs_written_also(function: Callable[..., Any], options: Mapping[str, Any]) -> dict[str, Path]:
    """The files that `writes_also` tells of a command."""
    outputs = getattr(function, _WRITES_ALSO, lambda options: {})(options)
    return {name: path for name, path in outputs.items() if path is not None}


def refuse_shared_files(ctx: click.Context, written_also: Mapping[str, Path]) -> None:
    """Raises Refused where a file that the command would write is one that it reads, or writes already."""
    inputs, outputs, folders = [], list(written_also.items()), []
    kinds: list[tuple[Path, str]] = []
    for param in ctx.command.params:
        given = ctx.params.get(str(param.name))
        name = param.opts[0] if isinstance(param, click.Option) else param.human_readable_name
        for path in given if isinstance(given, tuple) else (given,):
            if not isinstance(path, Path) or (isinstance(param.type, JsonOutput) and str(path) == STANDARD_OUTPUT):
                continue
            if isinstance(param.type, OutputFolder):
                folders.append((path, param.type.files))
            elif isinstance(param.type, OutputFile):
                outputs.append((name, path))
                kinds += [(path, param.type.yaml_kind)] if param.type.yaml_kind else []
            else:
                inputs.append((name, path))
    out, export_as = ctx.params.get("out"), ctx.params.get("export_as")
    if isinstance(out, Path) and export_as in EXPORT_FORMATS:
        outputs.append((f"--export {export_as}", out.with_suffix(f".{export_as}")))
    _refuse_shared(inputs, outputs, folders)
    for _, path in outputs:
        check_output(path)
    for path, kind in kinds:
        check_kind(path, kind)


def _refuse_shared(
    inputs: Sequence[tuple[str, Path]],
    outputs: Sequence[tuple[str, Path]],
    folders: Sequence[tuple[Path, Sequence[str]]] = (),
) -> None:
    """Raises Refused where an output is an input or another output, or a file in one of `folders` would be.

    inputs, outputs: what the person called a file, and the file. folders: a folder of results, and the patterns of the names in it.
    """
    for k, (name, path) in enumerate(outputs):
        for other, input_file in inputs:
            if same_file(path, input_file):
                raise Refused(
                    path, f"{name} is an input too, {other}", "write to another file: no input is ever changed"
                )
        for other, output in outputs[:k]:
            if same_file(path, output):
                raise Refused(path, f"{other} and {name} are one file", "give each a file of its own")
    for folder, patterns in folders:
        for name, path in inputs:
            if _lies_in(path, folder, patterns):
                what = f"results would replace {path}, an input ({name})"
                raise Refused(folder, what, "write to another folder: no input is ever changed")
        for name, path in outputs:
            if _lies_in(path, folder, patterns):
                raise Refused(path, f"{name} is one of the files that go to {folder}", "give it another name")


def _lies_in(path: Path, folder: Path, patterns: Sequence[str]) -> bool:
    """Whether a path leads to a file of one of the patterns in the folder."""
    real, inside = real_path(path), real_path(folder)
    if not real.is_relative_to(inside):
        return False
    parts = real.relative_to(inside).parts
    wanted = [pattern.split("/") for pattern in patterns]
    return any(len(w) == len(parts) and all(map(fnmatch.fnmatchcase, parts, w)) for w in wanted)
