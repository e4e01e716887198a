"""xneck replaces files that it wrote, and no other, and its mark changes nothing of what other programs read."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest
import scipy.io
import yaml
from hypothesis import given
from hypothesis import strategies as st

from identification.dataset.dataset_file import export_series
from identification.dataset.series import Series
from identification.files import joint_state
from xneck_foundation.authorship import MARK, written_by_xneck
from xneck_foundation.errors import Refused
from xneck_foundation.json_text import json_text, read_record
from xneck_foundation.whole_file import replacing_any_file, whole_file, write_text

SERIES = Series(
    np.asarray(1.7634e9 + np.arange(50) * 0.002, dtype=np.float64),
    {"a": np.sin(np.arange(50.0)), "b": np.full(50, np.nan)},
)


def text_writer(text: str) -> Callable[[Path], None]:
    return lambda path: write_text(path, text)


def write_video(path: Path) -> None:
    with whole_file(path) as part, av.open(str(part), "w", options={"fflags": "+bitexact"}) as container:
        container.metadata["comment"] = MARK
        stream = container.add_stream("libx264", rate=30)
        stream.width = stream.height = 64
        stream.pix_fmt = "yuv420p"
        container.mux(stream.encode(av.VideoFrame.from_ndarray(np.zeros((64, 64, 3), np.uint8), format="rgb24")))
        container.mux(stream.encode(None))


WRITERS = {
    "a.yaml": text_writer("a: 1\n"),
    "a.json": text_writer(json_text({"a": [1]})),
    "empty.json": text_writer("{}\n"),
    "a": text_writer(json_text({"a": 1})),
    "a.html": text_writer("<p>a</p>"),
    "a.svg": text_writer("<svg xmlns='http://www.w3.org/2000/svg'/>\n"),
    "a.md": text_writer("# a\n"),
    "a.csv": lambda path: export_series(SERIES, path),
    "a.npz": lambda path: export_series(SERIES, path),
    "a.mat": lambda path: export_series(SERIES, path),
    "a.mcap": lambda path: joint_state.write(path, {"a": SERIES}, {}),
    "a.mp4": write_video,
    "a.mkv": write_video,
}
TEXT = [name for name in WRITERS if Path(name).suffix not in (".npz", ".mat", ".mcap", ".mp4", ".mkv")]


@pytest.mark.parametrize("name", WRITERS)
def test_what_xneck_wrote_it_replaces_with_the_same_bytes(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    before = path.read_bytes()
    WRITERS[name](path)
    assert path.read_bytes() == before
    moved = path.rename(tmp_path / f"moved{path.suffix}")
    assert written_by_xneck(moved)


@pytest.mark.parametrize("name", TEXT)
def test_what_a_person_changed_since_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    content = bytearray(path.read_bytes())
    digits = [k for k, byte in enumerate(content) if chr(byte) in "19a"]
    content[digits[0]] = ord("8")
    path.write_bytes(content)
    with pytest.raises(Refused, match="not as xneck wrote it"):
        WRITERS[name](path)
    assert path.read_bytes() == content
    with replacing_any_file():
        WRITERS[name](path)
    assert path.read_bytes() != content


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("content", [b"x", b"{}", b"time,a\n0.0,1\n", b"PK\x05\x06" + bytes(18), bytes(300)])
def test_what_somebody_else_wrote_is_refused(name: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(Refused, match="give --force"):
        WRITERS[name](path)
    assert path.read_bytes() == content
    assert list(tmp_path.iterdir()) == [path]


def test_a_yaml_is_not_replaced_by_one_of_another_kind(tmp_path: Path) -> None:
    """A description with a comment above its first key, a model, and a camera as ROS has it."""
    kinds = {"xneck": "# an arm\nxneck: 1\n", "model": "xneck_model: 1\n", "camera": "image_width: 640\n"}
    path = tmp_path / "a.yaml"
    for there in kinds:
        for other in kinds:
            with replacing_any_file():
                write_text(path, kinds[there])
            if other == there:
                write_text(path, kinds[other] + "more: 1\n")
                continue
            before = path.read_bytes()
            with pytest.raises(Refused, match=r"is .*, and would be replaced by "):
                write_text(path, kinds[other])
            assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_an_empty_file_has_nothing_to_lose(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").touch()
    write_text(tmp_path / "a.yaml", "a: 1\n")
    assert yaml.safe_load((tmp_path / "a.yaml").read_text()) == {"a": 1}


def test_other_programs_read_the_same_numbers(tmp_path: Path) -> None:
    for kind in ("csv", "npz", "mat"):
        export_series(SERIES, tmp_path / f"a.{kind}")
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    with (tmp_path / "a.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    archive, mat = np.load(tmp_path / "a.npz"), scipy.io.loadmat(tmp_path / "a.mat")
    for name, values in {"time": SERIES.time, **SERIES.columns}.items():
        assert np.array_equal(table[name], values, equal_nan=True)
        assert np.array_equal([float(row[name] or "nan") for row in rows], values, equal_nan=True)
        assert np.array_equal(archive[name], values, equal_nan=True)
        assert np.array_equal(mat[name].ravel(), values, equal_nan=True)
    write_text(tmp_path / "a.json", json_text({"b": 1}))
    assert list(json.loads((tmp_path / "a.json").read_text())) == ["b", "written_by"]
    assert read_record(tmp_path / "a.json") == {"b": 1}


@given(st.floats(-(2.0**31), 2.0**31, allow_subnormal=False))
def test_the_last_time_of_a_csv_keeps_its_value(tmp_path_factory: pytest.TempPathFactory, time: float) -> None:
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    export_series(Series(np.array([time - 1, time]), {"a": np.zeros(2)}), path)
    assert float(path.read_text().splitlines()[-1].split(",")[0]) == time
