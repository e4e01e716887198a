"""xneck watch."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from xneck.cli.files_apart import refuse_shared_files
from xneck.cli.path_types import FOLDER, INPUT_FILE, STANDARD_OUTPUT, JsonOutput, OutputFolder
from xneck.cli.terminal import print_error, print_text
from xneck.recording.result_files import WATCH_FILES, WATCHED_TRACKS
from xneck_foundation.authorship import MARK
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_line
from xneck_foundation.whole_file import check_output, replacing_any_file

_LINES_SUFFIX = ".jsonl"


@click.command(
    epilog="Example: xneck watch monday/ --out results, and when it has ended: xneck run monday/ --out results"
)
@click.argument("folder", metavar="FOLDER", type=FOLDER)
@click.option(
    "--out",
    type=OutputFolder(WATCH_FILES),
    default=Path("results"),
    show_default=True,
    help="What `run` goes on from is kept here, in a folder for the recording: give `run` the same.",
)
@click.option("--neck", type=INPUT_FILE, help="neck.yaml, in the place of the one that recording.yaml names.")
@click.option("--camera", type=INPUT_FILE, help="camera.yaml, likewise.")
@click.option(
    "--ended-after",
    type=click.FloatRange(0.5, 3600),
    default=5.0,
    show_default=True,
    help="The recording has ended when neither file has grown for so many seconds.",
)
@click.option(
    "--json",
    "json_out",
    type=JsonOutput(),
    metavar="FILE",
    help="A line of JSON for each event as it comes (NAME.jsonl); - for standard output.",
)
@click.option("--force", is_flag=True, help="Replace files too that xneck did not write. Inputs never.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors and warnings.")
def command(
    folder: Path,
    out: Path,
    neck: Path | None,
    camera: Path | None,
    ended_after: float,
    json_out: Path | None,
    force: bool,
    quiet: bool,
) -> None:
    """Watches a recording while the experiment runs, and says what will make it useless.

    That is: markers out of sight, wrong light, wrong signs or units, a motion that tells no clock, lost frames, gaps of the log.
    When it has ended, or on Ctrl-C: its clock, and what it will identify.

    FOLDER has the recording.yaml; video and log may not be there yet. The video must be readable while it grows: mkv, MPEG-TS or
    fragmented mp4. Nothing is written to but --out and --json.
    """
    from xneck.recording.recording_folder import SharedFiles, read_recording
    from xneck.watch.watch import watch

    with _replacing(force):
        refuse_shared_files(click.get_current_context(), {})
        recording = read_recording(folder, SharedFiles(neck, camera), growing=True)
        if recording.video is None:
            raise Refused(recording.config, "names angles, which do not grow", "watch a recording with a video")
        tracks = out / (folder.resolve().name if folder.is_dir() else recording.folder.resolve().name) / WATCHED_TRACKS
        if tracks.parent.is_dir():
            check_output(tracks)
        if not quiet and str(json_out) != STANDARD_OUTPUT:
            print_text(f"watching {recording.video.name} and {recording.log.name} of {folder}; Ctrl-C ends it")
        with _lines(json_out) as write_line:

            def say(event: dict[str, Any]) -> None:
                write_line(event)
                if str(json_out) == STANDARD_OUTPUT:
                    return
                text = event_text(event)
                if event["event"] == "finding" and quiet:
                    print_error(f"warning: {text}")
                elif not quiet:
                    print_text(text)

            watch(recording, say, ended_after, tracks)


def event_text(event: dict[str, Any]) -> str:
    """An event in words."""
    kind = event["event"]
    if kind == "finding":
        do = f"; {event['do']}" if event["do"] else ""
        return f"{event['kind']}: {event['what']} (since {event['onset_s']:.2f} s of the {event['clock']}'s clock){do}"
    if kind == "behind":
        if event["skips"]:
            return f"xneck is {event['behind_s']:.1f} s behind the video: it skips frames, which `run` will read"
        return "xneck has caught up with the video"
    if kind == "outcome":
        from xneck.watch.outcome_text import outcome_text

        return outcome_text(event)
    found = event["findings"]
    said = "nothing was found wrong" if not found else f"{found} finding{'s' * (found > 1)}"
    return (
        f"{said} in {event['frames']} frames ({event['frames_skipped']} skipped) and {event['rows']} rows; `run` goes on from "
        f"{event['frames_kept_for_run']} frames"
    )


@contextmanager
def _lines(json_out: Path | None) -> Iterator[Callable[[dict[str, Any]], None]]:
    """What writes an event as a line of JSON at once, to be seen by who follows the file."""
    if json_out is None:
        yield lambda event: None
        return
    if str(json_out) == STANDARD_OUTPUT:
        yield lambda event: click.echo(json_line(event))
        return
    if json_out.suffix.lower() != _LINES_SUFFIX:
        raise Refused(json_out, "lines of JSON are no JSON file", f"name it with {_LINES_SUFFIX}")
    check_output(json_out)
    with json_out.open("w", encoding="utf-8") as stream:

        def write(event: dict[str, Any]) -> None:
            stream.write(json_line(event) + "\n")
            stream.flush()

        write({"event": "begin", "written_by": MARK})
        yield write


@contextmanager
def _replacing(force: bool) -> Iterator[None]:
    if force:
        with replacing_any_file():
            yield
    else:
        yield
