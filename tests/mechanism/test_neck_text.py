"""What is written as neck.yaml is read back as the same arm."""

from pathlib import Path

import pytest
import yaml

from mechanism.description import read_neck
from mechanism.neck_text import neck_text
from mechanism.printed_markers import BarMarker
from tests.paths import NECK_FILE

FILE = NECK_FILE


@pytest.mark.parametrize("markers", [True, False])
def test_round_trip(tmp_path: Path, markers: bool) -> None:
    neck = read_neck(FILE)
    assert neck.markers is not None
    placed = (
        neck.markers.on_bars[0],
        BarMarker(id=7, diagonal="B2", at=(1e-5, -0.123456789012345), angle=-3.1),
        BarMarker(id=8, bar=3),
    )
    changed = neck.markers.model_copy(update={"on_bars": placed}) if markers else None
    motors = tuple(m.model_copy(update={"joint": f"winch 'a': \\{j}"}) for j, m in enumerate(neck.motors))
    neck = neck.model_copy(update={"markers": changed, "motors": motors, "gravity": (0.1, -9.8)})
    out = tmp_path / "neck.yaml"
    out.write_text(neck_text(neck, "where the recording showed\nthe markers to be"), encoding="utf-8")
    assert out.read_text().startswith("# where the recording showed\n# the markers to be\nxneck: 1\n")
    assert read_neck(out) == neck
    # readers of YAML 1.1 take the same numbers
    assert yaml.safe_load(out.read_text())["mechanisms"][0]["diagonal"]["inertia"] == 2.5e-5
