"""From angles and a log to the verdict where neither OpenCV nor PyAV can be imported: only `vision` and `calibration` need them."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import SAMPLES

BLOCKED = '''
import sys

class NoCamera:
    """Refuses the libraries that read pictures and videos."""

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("cv2", "av"):
            raise ImportError(f"{name} is not here")
        return None

sys.meta_path.insert(0, NoCamera())
'''
FUNCTIONS = """
from pathlib import Path

import xneck
from identification.dataset.dataset_file import export_series
from identification.model_file import model_of
from mechanism.description import read_neck
from synchronisation.angles import read_angles, write_angles
from synchronisation.encoder_log import read_log
from synchronisation.synchronise import synchronise
from xneck_foundation.strict_yaml import read_text

sample, work = Path(sys.argv[1]), Path(sys.argv[2])
neck = read_neck(sample / "neck.yaml")
write_angles(read_angles(sample / "angles.csv", neck.N), work / "angles.csv")
export_series(read_log(sample / "log.mcap", neck), work / "log.csv")
(work / "neck.yaml").write_text(read_text(sample / "neck.yaml"))

angles, log = read_angles(work / "angles.csv", neck.N), read_log(work / "log.csv", neck)
data = synchronise(neck, read_text(work / "neck.yaml"), angles, log, {})
assert xneck.check(data).verdict == "consistent"
estimates = xneck.identify([data])
assert any(p.name == "k" and p.identified for p in estimates.parameters)
model = model_of(estimates.parameters, estimates.laws, {}, estimates.covariance)
assert len(xneck.simulate(data, model).channels) == neck.N + neck.M
found = xneck.diagnose([data])
print(found.verdict)
assert xneck.as_record(found)["verdict"] == found.verdict
"""
COMMANDS = """
import shlex
from xneck.cli import main

for command in (
    "sync angles.csv log.csv --neck neck.yaml --out dataset.mcap",
    "check dataset.mcap",
    "identify dataset.mcap --out model.yaml",
    "simulate dataset.mcap --model model.yaml --out simulated.mcap",
    "diagnose dataset.mcap --out diagnosis",
):
    sys.argv = ["xneck", *shlex.split(command), "--quiet"]
    try:
        main()
    except SystemExit as end:
        assert not end.code, command
"""
NOT_IMPORTED = """
assert not {"cv2", "av", "vision", "calibration"} & set(sys.modules)
"""


def run(folder: Path, code: str, *arguments: str | Path) -> str:
    """Standard output of an interpreter without a camera's libraries, in `folder`."""
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED + code + NOT_IMPORTED, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """A folder with angles.csv, log.csv and neck.yaml, and the verdict that Python's functions give on them."""
    folder = tmp_path_factory.mktemp("without_camera")
    return folder, run(folder, FUNCTIONS, SAMPLES / "held_out", folder).strip()


def test_functions_go_from_csv_files_to_a_verdict(exported: tuple[Path, str]) -> None:
    assert exported[1] in ("consistent", "cause", "ambiguous", "unknown", "insufficient")


def test_commands_go_from_csv_files_to_the_same_verdict(exported: tuple[Path, str]) -> None:
    folder, verdict = exported
    run(folder, COMMANDS)
    assert f'"verdict": "{verdict}"' in (folder / "diagnosis" / "diagnosis.json").read_text()


@pytest.mark.parametrize("library", ["cv2", "av", "vision.extract", "calibration.estimation"])
def test_the_block_holds(library: str, tmp_path: Path) -> None:
    """A negative control: neither the libraries nor what needs them can be imported."""
    with pytest.raises(AssertionError, match="is not here"):
        run(tmp_path, f"import {library}")
