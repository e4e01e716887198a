"""Options and output that all commands share."""

import functools
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click
import numpy as np

from identification.dataset.dataset_file import EXPORT_FORMATS, export_series
from identification.dataset.series import Series
from xneck.cli.files_apart import outputs_written_also, refuse_shared_files
from xneck.cli.path_types import STANDARD_OUTPUT, JsonOutput
from xneck.cli.terminal import print_error, print_text
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text
from xneck_foundation.recovery import collected_recoveries
from xneck_foundation.whole_file import replacing_any_file, write_text

Command = TypeVar("Command", bound=Callable[..., Any])


_RECOVERED = "recovered"
"""key of the click context's notes, and of every result"""


def result_options(function: Command) -> Command:
    """Adds --json, --quiet and --force to a command, refuses outputs that are inputs, and collects what damaged files lost."""

    @functools.wraps(function)
    def collecting(*values: Any, **options: Any) -> Any:
        refuse_shared_files(click.get_current_context(), outputs_written_also(function, options))
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
        "--json", "json_out", type=JsonOutput(), metavar="FILE", help="Machine-readable result; - for standard output."
    )(command)
    command = click.option(
        "--force",
        is_flag=True,
        # before the files, which are checked as they are parsed
        is_eager=True,
        expose_value=False,
        callback=_replace_any_file,
        help="Replace files too that xneck did not write. Inputs never.",
    )(command)
    return command  # type: ignore[return-value]


def _replace_any_file(ctx: click.Context, param: click.Parameter, given: bool) -> None:
    if given:
        ctx.with_resource(replacing_any_file())


def recovered() -> list[str]:
    """What could not be read of the files that this command has read so far, a line each."""
    return list(click.get_current_context().meta[_RECOVERED])


def export_option(function: Command) -> Command:
    """Adds --export to a command."""
    return click.option(
        "--export", "export_as", type=click.Choice(EXPORT_FORMATS), help="The same series beside --out for other tools."
    )(function)


def report_result(
    result: dict[str, Any], text: str, json_out: Path | None, quiet: bool, warnings: Sequence[str] = ()
) -> None:
    """Writes the result as JSON where --json asks for it, and prints its text unless --quiet or --json has standard output.

    What could not be read of damaged files goes into the result's `recovered`, and with `warnings` to standard error.
    """
    lost = recovered()
    result = {**result, _RECOVERED: lost}
    for line in (*lost, *warnings):
        print_error(f"warning: {line}")
    if json_out is not None and str(json_out) == STANDARD_OUTPUT:
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
