"""What is installed is what is here: the wheel holds every file of the packages, the demo's recordings, and nothing else."""

import ast
import os
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGES: list[str] = PROJECT["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
HEAVY = {"numpy", "scipy", "cv2", "matplotlib", "av", "distributed", "dask", "pydantic"}


def tracked(*folders: str) -> set[str]:
    """Files under these folders that are not ignored, as git names them; a file not yet added counts."""
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", *folders]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, check=True)
    return {name for name in done.stdout.decode().split("\0") if name and (ROOT / name).is_file()}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Built by the backend itself, which asks no network."""
    if find_spec("hatchling") is None:
        pytest.skip("hatchling is not installed")
    place = tmp_path_factory.mktemp("wheel")
    build = "import sys; from hatchling.build import build_wheel; build_wheel(sys.argv[1])"
    subprocess.run([sys.executable, "-c", build, str(place)], cwd=ROOT, check=True, capture_output=True)
    (built,) = place.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path) -> Path:
    """A folder with what an installer would put into site-packages."""
    place = wheel.parent / "site"
    with ZipFile(wheel) as archive:
        archive.extractall(place)
    return place


def python(installed: Path, words: str) -> str:
    """What `words` print where the checkout cannot be found but for the wheel's files."""
    environment = os.environ | {"PYTHONPATH": str(installed)}
    done = subprocess.run(
        [sys.executable, "-c", words], cwd=installed.parent, env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_it_holds_every_file_of_the_packages_and_the_recordings_of_the_demo(wheel: Path) -> None:
    with ZipFile(wheel) as archive:
        inside = {name: archive.read(name) for name in archive.namelist() if ".dist-info/" not in name}
    wanted = {name: name for name in tracked(*PACKAGES)}
    wanted |= {f"xneck/{name}": name for name in tracked("samples/recording", "samples/held_out")}
    assert set(inside) == set(wanted)
    assert [name for name, source in wanted.items() if inside[name] != (ROOT / source).read_bytes()] == []


def test_alone_it_finds_its_templates_and_its_samples(installed: Path) -> None:
    words = """
import xneck.cli.demo, xneck.report.template, xneck.report.batch_page as pages, xneck
from xneck.recording.recording_folder import read_recording
from xneck_foundation.provenance import versions
for name in ("recording", "held_out"):
    print(read_recording(xneck.cli.demo.SAMPLES_FOLDER / name).log)
print(len(pages.batch_html({}, versions(), None)) > 1000, xneck.__file__)
"""
    *logs, page = python(installed, words).splitlines()
    assert [Path(log).is_relative_to(installed) for log in logs] == [True, True]
    assert page == f"True {installed / 'xneck/__init__.py'}"


def test_the_command_starts_without_what_computes(installed: Path) -> None:
    """`xneck --help` is there in a tenth of a second because none of these is loaded."""
    words = "import sys, xneck.cli; print(*{name.split('.')[0] for name in sys.modules})"
    assert not set(python(installed, words).split()) & HEAVY


def test_what_is_imported_is_declared() -> None:
    """By the packages themselves, not by what they happen to bring along; extras are what a person asks for."""
    extras = [
        name for key, names in PROJECT["project"]["optional-dependencies"].items() if key != "dev" for name in names
    ]
    declared = [*PROJECT["project"]["dependencies"], *extras]
    names = {line.split(">")[0].lower() for line in declared}
    owners = packages_distributions()
    unknown: set[str] = set()
    for name in tracked(*PACKAGES):
        if not name.endswith(".py"):
            continue
        for node in ast.walk(ast.parse((ROOT / name).read_text(encoding="utf-8"))):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.module:
                modules = [node.module]
            for top in {module.split(".")[0] for module in modules} - set(PACKAGES) - sys.stdlib_module_names:
                if not names & {owner.lower() for owner in owners.get(top, ())}:
                    unknown.add(f"{name}: {top}")
    assert unknown == set()
