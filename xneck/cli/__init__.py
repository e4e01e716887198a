"""The command line: the only place that parses, prints and draws progress.

Commands are loaded when they are called, so that `xneck --help` does not wait for OpenCV.
"""

import copy
import importlib
import io
import sys

import click

from xneck.cli.terminal import print_error, print_text
from xneck_foundation.errors import MAX_CHARACTERS, Refused
from xneck_foundation.one_blas_thread import one_blas_thread
from xneck_foundation.one_line import shortened
from xneck_foundation.spelling import quoted, valid_words

COMMANDS = {
    "init": "Write a neck.yaml to fill in, with a comment for every key.",
    "logs": "Say what is in a log, and how neck.yaml must map it.",
    "show": "Draw the arm from its description, to check it with one's eyes.",
    "board": "Print a calibration board, or the arm's markers, at true scale.",
    "calibrate": "Calibrate the camera from pictures or a video of a board.",
    "extract": "Joint angles from a recorded video.",
    "sync": "Angles and encoder log to one checked data set.",
    "check": "Is vision consistent with the cable lengths of the pulley model?",
    "identify": "Friction and cable elasticity with their uncertainty.",
    "simulate": "The recorded forces through the model, beside what was measured.",
    "observe": "Joint angles at the log's rate without a camera.",
    "design": "A motion within limits that tells the parameters best.",
    "diagnose": "What the simulation gets wrong, its cause, and what the model gains by it.",
    "export": "The arm for MuJoCo, figures for papers, a package for an archive.",
    "watch": "A recording while it grows: is it going to be usable?",
    "run": "All of it for recording folders, and one report each.",
    "demo": "The same on the recording shipped in samples/.",
    "study": "Hides effects in generated data and counts how often they are found.",
}


class _Group(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = copy.copy(importlib.import_module(f"xneck.cli.{cmd_name}").command)
        command.callback = one_blas_thread(command.callback)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] not in COMMANDS and not args[0].startswith("-"):
            raise click.UsageError(f"no command {quoted(args[0])}; {valid_words(args[0], COMMANDS)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="xneck", prog_name="xneck")
def group() -> None:
    """What a cable-driven arm of tensegrity X-joints really did, from a camera and encoder logs.

    Each step reads and writes files; `xneck run FOLDER` does them all. Try `xneck demo`.
    """


def refuse_undecoded(arguments: list[str]) -> None:
    """Raises Refused where an argument is not UTF-8: what holds it is written at the end, after all work."""
    for argument in arguments:
        if any("\udc80" <= letter <= "\udcff" for letter in argument):
            shown = argument.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
            raise Refused(shown, "is not written in UTF-8, as a name of an old disk or archive", "rename it")


def main() -> None:
    """Entry point: refusals become one line on standard error and exit status 1."""
    try:
        refuse_undecoded(sys.argv[1:])
        status = group.main(prog_name="xneck", standalone_mode=False)
    except Refused as refusal:
        print_error(str(refusal))
        sys.exit(1)
    except click.ClickException as error:
        shown = io.StringIO()
        error.show(shown)
        print_text("\n".join(shortened(line, MAX_CHARACTERS) for line in shown.getvalue().splitlines()), error=True)
        sys.exit(error.exit_code)
    except (click.Abort, KeyboardInterrupt) as interruption:
        print_error("; ".join(["interrupted", "nothing half-written is left", *map(str, interruption.args)]))
        sys.exit(130)
    except BrokenPipeError:
        sys.exit(141)
    except UnicodeEncodeError as error:
        letters = error.object[error.start : error.end]
        what = f"{error.encoding} cannot write {letters!a}, which a name holds"
        print_error(f"{what}; rename what is not UTF-8, and set LC_ALL to C.UTF-8")
        sys.exit(1)
    except OSError as error:  # what the disk refuses: a folder that cannot be made, a file that vanished
        print_error(str(Refused(str(error.filename or "output"), error.strerror or str(error))))
        sys.exit(1)
    except MemoryError:
        print_error("the memory of this machine does not suffice; give shorter recordings")
        sys.exit(1)
    sys.exit(status if isinstance(status, int) else 0)
