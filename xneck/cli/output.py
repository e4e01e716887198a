"""Options and output that all commands share."""

import errno
import functools
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np

from identification.dataset.dataset_file import EXPORT_FORMATS, export_series
from identification.dataset.series import Series
from xneck.cli.terminal import print_error, print_text
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text
from xneck_foundation.recovery import collected_recoveries
from xneck_foundation.whole_file import check_output, write_text

Command = TypeVar("Command", bound=Callable[..., Any])


class _OutputFile(click.ParamType):
    """A file to be written; whether it can be is checked before any work begins."""

    name = "file"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        check_output(Path(value))
        return Path(value)


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


INPUT_FILE = _InputPath(path_type=Path)
OUTPUT_FILE = _OutputFile()
FOLDER = _InputPath(path_type=Path, file_okay=False)


_RECOVERED = "recovered"
"""key of the click context's notes, and of every result"""


def result_options(function: Command) -> Command:
    """Adds --json and --quiet to a command, and collects what it could not read of damaged files."""

    @functools.wraps(function)
    def collecting(*values: Any, **options: Any) -> Any:
        with collected_recoveries() as warnings:
            click.get_current_context().meta[_RECOVERED] = warnings
            try:
                return function(*values, **options)
            except Refused as refusal:
                if warnings:
                    raise Refused(refusal.where, f"{refusal.what} ({'; '.join(warnings)})", refusal.do) from refusal
                raise
            except np.linalg.LinAlgError as error:
                name = str(click.get_current_context().info_name)
                what = f"the equations of these data cannot be solved ({error})"
                raise Refused(name, what, "is a column in another unit, or a clock off?") from error

    command = click.option("--quiet", is_flag=True, help="Print nothing but errors and warnings.")(collecting)
    command = click.option(
        "--json", "json_out", metavar="INPUT_FILE", help="Machine-readable result; - for standard output."
    )(command)
    return command  # type: ignore[return-value]


def recovered() -> list[str]:
    """What could not be read of the files that this command has read so far, a line each."""
    return list(click.get_current_context().meta[_RECOVERED])


def export_option(function: Command) -> Command:
    """Adds --export to a command."""
    return click.option(
        "--export", "export_as", type=click.Choice(EXPORT_FORMATS), help="The same series beside --out for other tools."
    )(function)


def report_result(result: dict[str, Any], text: str, json_out: str | None, quiet: bool) -> None:
    """Writes the result as JSON where --json asks for it, and prints its text unless --quiet or --json has standard output.

    What could not be read of damaged files goes into the result's `recovered`, and as warnings to standard error.
    """
    lost = recovered()
    result = {**result, _RECOVERED: lost}
    for line in lost:
        print_error(f"warning: {line}")
    if json_out == "-":
        click.echo(json_text(result), nl=False)
        return
    if json_out:
        write_text(json_out, json_text(result))
    if not quiet:
        print_text(text)


def export_beside(series: Series, out: Path, kind: str | None) -> None:
    """Writes `series` beside `out`, with the suffix of the format `kind`; nothing where that is None."""
    if kind:
        export_series(series, out.with_suffix(f".{kind}"))


@contextmanager
def progress_bar(total: int | None, what: str, quiet: bool) -> Iterator[Callable[[int], object]]:
    """A progress bar on a terminal, nothing elsewhere; yields the function to call with the number of steps done."""
    from tqdm import tqdm

    with tqdm(total=total, desc=what, disable=True if quiet else None, leave=False) as bar:
        yield bar.update
