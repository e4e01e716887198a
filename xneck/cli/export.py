"""xneck export."""

from pathlib import Path

import click

from xneck.cli.finite_range import FiniteRange
from xneck.cli.output import report_result, result_options
from xneck.cli.path_types import INPUT_FILE, OUTPUT_FILE, OutputFolder
from xneck_foundation.errors import Refused, one_of
from xneck_foundation.one_line import counted

_ENDINGS = ("xml", "zip")


@click.command(
    epilog="Example: xneck export diagnosis --out arm.xml; xneck export results/monday --figures figures; "
    "xneck export results --out results.zip --license CC-BY-4.0 --author 'A. Person'"
)
@click.argument("sources", metavar="FOLDER | NECK.yaml MODEL.yaml", nargs=-1, required=True, type=INPUT_FILE)
@click.option("--out", type=OUTPUT_FILE, help="arm.xml for MuJoCo, or package.zip for an archive (RO-Crate 1.1).")
@click.option(
    "--figures", "figures_folder", type=OutputFolder(("*.pdf",)), help="A folder for all figures of the pages, as PDF."
)
@click.option(
    "--timestep", type=FiniteRange(1e-6, 2e-3), default=2e-4, show_default=True, help="Of the simulation in MuJoCo, s."
)
@click.option(
    "--license", "licence", metavar="NAME", help="Of a package: an SPDX name, such as CC-BY-4.0, or an address."
)
@click.option("--author", "authors", multiple=True, metavar="NAME", help="Of a package, repeatable; NAME <ORCID> too.")
@click.option("--title", help="Of a package.  [the folder's name]")
@click.option("--date", metavar="YYYY-MM-DD", help="Of a package's publication.  [today]")
@result_options
def command(
    sources: tuple[Path, ...],
    out: Path | None,
    figures_folder: Path | None,
    timestep: float,
    licence: str | None,
    authors: tuple[str, ...],
    title: str | None,
    date: str | None,
    json_out: Path | None,
    quiet: bool,
) -> None:
    """Take results elsewhere. What is written follows from the ending of --out, or is asked for by --figures.

    arm.xml: the arm of a folder of `xneck diagnose`, or of NECK.yaml and MODEL.yaml, with its laws, for MuJoCo. A law that MuJoCo
    has no element for is refused by its name.

    package.zip: a folder of results as a research object for an archive, with what each file is, its size and hash, what it was
    made from and by which software. Whose it is and what others may do with it you say: --author, --license.

    --figures: the figures of all pages in a folder, each panel as a PDF with its fonts in it.
    """
    for source in sources:
        if not source.exists():
            raise Refused(source, "does not exist", "check the name")
    if figures_folder is not None and out is None:
        from xneck.export.figure_files import write_figure_files

        folder = _one_folder(sources)
        names = write_figure_files(folder, figures_folder)
        report_result({"files": names}, f"{figures_folder}: {counted(len(names), 'figure')}", json_out, quiet)
    elif out is not None and figures_folder is None:
        if one_of(out, out.suffix.removeprefix(".").lower(), _ENDINGS, "ending") == "xml":
            from xneck.export.mujoco_file import arm_files, write_mujoco_file

            record = write_mujoco_file(arm_files(sources), out, timestep)
            counts = f"{counted(record['mechanisms'], 'mechanism')}, {counted(record['cables'], 'cable')}"
            text = f"{out}: {counts}; {', '.join(record['laws'])}"
        else:
            from xneck.export.crate_metadata import PackageOptions
            from xneck.export.research_object import write_package

            options = PackageOptions(title=title, licence=licence, authors=authors, date=date)
            record = write_package(_one_folder(sources), out, options)
            text = f"{out}: {counted(len(record['files']), 'file')}, {record['bytes']} bytes"
            text += "".join(f"\n  {line}" for line in record["missing"])
        report_result(record, text, json_out, quiet)
    else:
        raise click.UsageError("give either --out or --figures")


def _one_folder(sources: tuple[Path, ...]) -> Path:
    if len(sources) != 1 or not sources[0].is_dir():
        what = "is no folder of results" if len(sources) == 1 else "are several"
        raise Refused(", ".join(map(str, sources)), what, "give one folder that xneck wrote")
    return sources[0]
