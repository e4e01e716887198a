"""Types of the options and arguments that name files and folders."""

import errno
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import MODEL_KIND, NECK_KIND, check_place

STANDARD_OUTPUT = "-"
_OTHER_FORMATS = {".csv", ".tsv", ".txt", ".npz", ".npy", ".mat", ".parquet", ".h5", ".hdf5", ".bag"}
"""that some would take by its name for what a data set is written in"""


class OutputFile(click.ParamType):
    """A file to be written, where one can be; whether it may replace what is there is checked with all files known."""

    name = "file"

    def __init__(self, yaml_kind: str | None = None) -> None:
        """yaml_kind: what is written, where it is a YAML whose place no other kind of YAML may lose."""
        self.yaml_kind = yaml_kind

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        _no_standard_output(self, value, param, ctx)
        check_place(Path(value))
        return Path(value)


class DataSetOutput(OutputFile):
    """An MCAP file to be written: a name that says another format would mislead whoever opens it."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path = super().convert(value, param, ctx)
        if path.suffix.lower() in _OTHER_FORMATS:
            what = f"would be an MCAP, whatever {path.suffix} says"
            raise Refused(
                path, what, f"call it {path.with_suffix('.mcap').name}; `--export` writes other formats beside it"
            )
        return path


class JsonOutput(OutputFile):
    """A file for the result, or - for standard output."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        return Path(value) if str(value) == STANDARD_OUTPUT else super().convert(value, param, ctx)


class _InputPath(click.Path):
    """A path that can be followed: links in a circle are refused before anything reads them."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        try:
            path.stat()
        except OSError as error:
            if error.errno == errno.ELOOP:
                raise Refused(path, f"cannot be read ({error.strerror})") from error
        return path


class OutputFolder(_InputPath):
    """A folder for results; `files` are the names that may appear in it, with * for those of recordings and cases."""

    def __init__(self, files: Sequence[str]) -> None:
        super().__init__(path_type=Path, file_okay=False)
        self.files = tuple(files)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        _no_standard_output(self, value, param, ctx)
        return super().convert(value, param, ctx)


def _no_standard_output(
    kind: click.ParamType, value: Any, param: click.Parameter | None, ctx: click.Context | None
) -> None:
    """Fails where - is given, which other tools take for standard output: it would become a file of that name."""
    if str(value) == STANDARD_OUTPUT:
        kind.fail(f"only --json goes to standard output: give a {kind.name}", param, ctx)


INPUT_FILE = _InputPath(path_type=Path)
OUTPUT_FILE = OutputFile()
DATA_SET_OUTPUT = DataSetOutput()
NECK_OUTPUT, MODEL_OUTPUT = OutputFile(NECK_KIND), OutputFile(MODEL_KIND)
FOLDER = _InputPath(path_type=Path, file_okay=False)
