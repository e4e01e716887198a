"""xneck demo."""

from pathlib import Path

import click

from xneck.cli.output import result_options
from xneck.cli.path_types import FOLDER, OutputFolder
from xneck.recording.result_files import BATCH_FILES

_PACKAGE = Path(__file__).resolve().parents[1]
_PACKED = _PACKAGE / "samples"
SAMPLES_FOLDER = _PACKED if _PACKED.is_dir() else _PACKAGE.parent / "samples"
"""the two recordings that a wheel holds, or those of the checkout"""


@click.command(epilog="Example: xneck demo --out out")
@click.option(
    "--out",
    type=OutputFolder(BATCH_FILES),
    default=Path("out"),
    show_default=True,
    help="A folder for each recording here.",
)
@click.option(
    "--samples",
    type=FOLDER,
    default=SAMPLES_FOLDER,
    help="The samples folder of a checkout.  [default: those that came with it]",
)
@result_options
def command(out: Path, samples: Path, json_out: Path | None, quiet: bool) -> int:
    """The main job on the recordings shipped in samples/: a video with its log, and angles with theirs.

    Then what the simulation gets wrong of this arm, fitted to the first and held against the second: summary.html leads to it.
    """
    from xneck.batch.run_batch import BatchOptions
    from xneck.cli.run import run_recordings
    from xneck_foundation.errors import Refused

    folders = (samples / "recording", samples / "held_out")
    if not all(folder.is_dir() for folder in folders):
        raise Refused(samples, "holds no samples", "give the samples folder of a checkout with --samples")
    return run_recordings(folders, BatchOptions(out), json_out, quiet, held_out=folders[1].name)
