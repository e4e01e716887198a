"""What commands print: line by line, with nothing in it that a terminal would obey."""

import click

from xneck_foundation.one_line import printable


def print_text(text: str, *, error: bool = False) -> None:
    """`text` on standard output or standard error; only its line ends stay, other control characters become escapes."""
    click.echo("\n".join(map(printable, text.split("\n"))), err=error)


def print_error(line: str) -> None:
    """One line of trouble on standard error, after the program's name."""
    click.echo(f"xneck: {printable(line)}", err=True)
