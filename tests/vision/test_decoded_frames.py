"""Frames that a decoder hands over damaged or out of order are refused by number: a decoder made up, which does just that."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vision import video
from vision.video import Segment, Video, read_segments
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import file_identity


@dataclass
class Picture:
    """As PyAV has it."""

    pts: int | None
    is_corrupt: bool = False
    width: int = 8
    time_base: Fraction = Fraction(1, 30)

    @property
    def format(self) -> Any:
        return SimpleNamespace(name="rgb24", components=[SimpleNamespace(bits=8)])

    def to_ndarray(self, format: str) -> np.ndarray:
        return np.full((4, self.width), self.pts or 0, dtype=np.uint8)


def shown(monkeypatch: pytest.MonkeyPatch, path: Path, pictures: list[Picture], container: str = "matroska") -> list:
    """The frames of a file whose decoder gives these pictures."""

    class Container:
        format = SimpleNamespace(name=container)

        def __enter__(self) -> "Container":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def decode(self, stream: object) -> Iterator[Picture]:
            yield from pictures

    path.write_bytes(b"film")
    monkeypatch.setattr(video, "open_video", lambda path: (Container(), SimpleNamespace()))
    described = Video(
        path=path,
        identity=file_identity(path),
        width=8,
        height=4,
        frames=len(pictures),
        quarter_turns=0,
        segments=(Segment(0, len(pictures), 0, None),),
        warnings=(),
    )
    return list(read_segments(described))


def test_whole_frames_in_order_are_shown(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    frames = shown(monkeypatch, tmp_path / "a.mkv", [Picture(k) for k in (0, 1, 3)])
    assert [frame.time for frame in frames] == [0.0, 1 / 30, 0.1]
    assert [frame.index for frame in frames] == [0, 1, 2]


def test_a_frame_that_the_decoder_marks_as_damaged_is_no_measurement(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Its picture may be mended from the one before: markers would be found in it where they were."""
    with pytest.raises(Refused, match="frame 2 is damaged"):
        shown(monkeypatch, tmp_path / "a.mkv", [Picture(0), Picture(1), Picture(2, is_corrupt=True), Picture(3)])


@pytest.mark.parametrize("stamps", [(0, 2, 1, 3), (0, 1, 1, 2)])
def test_time_never_runs_back_or_stands_still(
    stamps: tuple[int, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pictures = [Picture(k) for k in stamps]
    with pytest.raises(Refused, match="frame 2 is not later than the one before"):
        shown(monkeypatch, tmp_path / "a.mkv", pictures)
    with pytest.raises(Refused, match="AVI cannot hold the stamps of B-frames"):
        shown(monkeypatch, tmp_path / "a.avi", pictures, "avi")


def test_a_frame_of_another_size_or_without_a_stamp_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with pytest.raises(Refused, match="frame 1 is 6x4, those before it are 8x4"):
        shown(monkeypatch, tmp_path / "a.mkv", [Picture(0), Picture(1, width=6)])
    with pytest.raises(Refused, match="frame 1 has no time stamp"):
        shown(monkeypatch, tmp_path / "a.mkv", [Picture(0), Picture(None)])
