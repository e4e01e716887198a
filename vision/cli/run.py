"""xneck run."""

from pathlib import Path

import click

from vision.cli.output import FILE, FOLDER, recovered, report_result, results


@click.command(epilog="Example: xneck run recordings/monday --out results")
@click.argument("folders", metavar="RECORDING...", nargs=-1, required=True, type=FILE)
@click.option(
    "--out", type=FOLDER, default=Path("results"), show_default=True, help="A folder for each recording here."
)
@results
def command(folders: tuple[Path, ...], out: Path, json_out: str | None, quiet: bool) -> None:
    """All of it for recording folders (each with a recording.yaml), and one HTML report each."""
    summary = run_all(folders, out, quiet)
    lines = [text_of(name, record) for name, record in summary.items()]
    report_result({"recordings": summary}, "\n".join(lines), json_out, quiet)


def run_all(folders: tuple[Path, ...], out: Path, quiet: bool) -> dict[str, dict[str, object]]:
    """Runs recordings one after the other; the record of each by its folder's name."""
    from tqdm import tqdm

    from identification.tables import as_json as tables_json
    from vision.pipeline import run_recording
    from vision.recording import read_recording
    from vision.report import write_report
    from xneck.errors import Refused
    from xneck.json_text import as_json
    from xneck.whole_file import write_text

    recordings = [read_recording(folder) for folder in folders]
    names = [recording.folder.resolve().name for recording in recordings]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise Refused("run", f"two recordings are called {twice[0]}", "run them into different --out folders")
    summary: dict[str, dict[str, object]] = {}
    with tqdm(total=6 * len(recordings), disable=True if quiet else None, leave=False) as bar:
        for name, recording in zip(names, recordings, strict=True):

            def stage(what: str, name: str = name) -> None:
                bar.set_description(f"{name}: {what}")
                bar.update()

            folder = out / name
            folder.mkdir(parents=True, exist_ok=True)
            before = len(recovered())
            result = run_recording(recording, folder, stage)
            write_report(result, folder / "report.html")
            record: dict[str, object] = {
                "report": str(folder / "report.html"),
                "sync": dict(result.data.clock),
                "check": dict(result.data.check),
                "identify": tables_json(result.identification),
                "simulate": result.simulated.rms if result.simulated else None,
                "recovered": recovered()[before:],
            }
            if result.extraction:
                record["extract"] = result.extraction.as_json()
            write_text(folder / "result.json", as_json(record))
            summary[name] = record
    return summary


def text_of(name: str, record: dict[str, object]) -> str:
    """One recording in one line."""
    sync, check = record["sync"], record["check"]
    assert isinstance(sync, dict)
    assert isinstance(check, dict)
    return (
        f"{name}: {sync['frames_used']} of {sync['frames']} frames, offset {sync['offset_s']:.4f} s "
        f"+- {1e3 * sync['offset_sigma_s']:.2f} ms, {check['verdict']}; {record['report']}"
    )
