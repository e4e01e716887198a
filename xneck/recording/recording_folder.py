"""A recording folder: recording.yaml and the files it names."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from vision.light_patch import LightPatch
from vision.shutter import Shutter, Stamp
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import Strict, read_yaml

RECORDING_FILE = "recording.yaml"
_PATH_KEYS = ("log", "neck", "video", "camera", "board", "pictures", "angles")
"""in the order in which recording.yaml's files are looked for"""
_RECORDED = ("log", "video")
"""keys of the files that are written during the experiment"""


class _Rectangle(Strict):
    x: Annotated[int, Field(ge=0)]
    y: Annotated[int, Field(ge=0)]
    width: Annotated[int, Field(ge=1)]
    height: Annotated[int, Field(ge=1)]


class _File(Strict):
    log: str
    neck: str
    video: str | None = None
    camera: str | None = None
    board: str | None = None
    pictures: str | None = None
    angles: str | None = None
    exposure: Annotated[float, Field(ge=0, le=1)] = 0.0
    row_time: Annotated[float, Field(ge=-1e-3, le=1e-3)] = 0.0
    stamp: Stamp = "middle"
    placement: Literal["believed", "estimated"] = "believed"
    corners: Literal["template", "edges"] = "template"
    anchor: _Rectangle | None = None


@dataclass(frozen=True)
class Recording:
    """Paths of one recording. Either `angles`, or `video` with `camera` or with `board` and `pictures` (a folder)."""

    folder: Path
    config: Path
    """the recording.yaml itself"""
    log: Path
    neck: Path
    video: Path | None
    camera: Path | None
    board: Path | None
    pictures: tuple[Path, ...]
    angles: Path | None
    shutter: Shutter
    estimate_placement: bool
    """whether the markers' places on their bars are estimated from the motion, rather than taken from neck.yaml"""
    template: bool
    """whether corners are fitted to all grey levels of a marker, rather than to its edges"""
    light: LightPatch | None
    """the rectangle of the video with a light that the controller switches and logs as `led`"""

    @property
    def files(self) -> dict[str, Path]:
        """The files that are read beside recording.yaml, by role."""
        files = {"neck": self.neck, "log": self.log}
        if self.angles is not None:
            return files | {"angles": self.angles}
        assert self.video is not None
        if self.camera is not None:
            files["camera"] = self.camera
        else:
            assert self.board is not None
            files["board"] = self.board
            files |= {f"picture {path.name}": path for path in self.pictures}
        return files | {"video": self.video}


def read_recording(folder: str | Path, growing: bool = False) -> Recording:
    """The recording in a folder (or in a recording.yaml itself); a `growing` one may lack its video and its log yet.

    Raises Refused where keys do not fit together, a file is missing, or a path leaves the folder.
    """
    folder = Path(folder)
    config = folder if folder.is_file() else folder / RECORDING_FILE
    if not config.is_file():
        raise Refused(folder, f"has no {RECORDING_FILE}", "write one with the keys video, log, camera, neck")
    file = read_yaml(config, _File)
    _check_keys(config, file)
    paths = {
        key: _path_inside(config, key, getattr(file, key), must_exist=not (growing and key in _RECORDED))
        for key in _PATH_KEYS
    }
    log, neck, pictures = paths["log"], paths["neck"], paths["pictures"]
    assert log is not None
    assert neck is not None
    return Recording(
        folder=config.parent,
        config=config,
        log=log,
        neck=neck,
        video=paths["video"],
        camera=paths["camera"],
        board=paths["board"],
        pictures=() if pictures is None else _picture_files(pictures),
        angles=paths["angles"],
        shutter=Shutter(file.exposure, file.row_time, file.stamp),
        estimate_placement=file.placement == "estimated",
        template=file.corners == "template",
        light=LightPatch(**file.anchor.model_dump()) if file.anchor else None,
    )


def _check_keys(config: Path, file: _File) -> None:
    """Refused where the keys name no angles and no complete video, or both."""
    if file.angles is None:
        if file.video is None:
            raise Refused(config, "names neither a video nor angles", "give `video` and `camera`, or `angles`")
        if (file.camera is None) == (file.board is None or file.pictures is None):
            raise Refused(config, "a video needs `camera`, or `board` and `pictures` to calibrate it")
    elif file.video or file.camera:
        raise Refused(config, "names both angles and a video", "leave one of them out")


def _path_inside(config: Path, key: str, name: str | None, must_exist: bool = True) -> Path | None:
    """The file that `key` names, in the folder of recording.yaml. Raises Refused where it is not there and must be."""
    if name is None:
        return None
    path = config.parent / name
    try:
        real, exists = Path(os.path.realpath(path)), path.exists()
    except (OSError, ValueError) as error:
        raise Refused(config, f"{key}: {name!r} is no file's name", "check the name") from error
    if not real.is_relative_to(os.path.realpath(config.parent)):
        raise Refused(config, f"{key}: {name} leaves the recording's folder", "keep its files inside")
    if must_exist and not exists:
        raise Refused(config, f"{key}: {name} does not exist", "check the name")
    return path


def _picture_files(folder: Path) -> tuple[Path, ...]:
    """The pictures of a board in a folder."""
    from calibration.pictures import picture_files  # needs OpenCV, which a recording with angles goes without

    return tuple(picture_files(folder))
