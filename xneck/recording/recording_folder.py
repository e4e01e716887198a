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


class RecordingFile(Strict):
    """recording.yaml; paths are relative to it."""

    log: str
    """the controller's log: .csv or .mcap"""
    neck: str | None = None
    """the description of the arm; may be named once for all recordings instead: xneck run --neck"""
    video: str | None = None
    """the video; with camera, or with board and pictures"""
    camera: str | None = None
    """camera.yaml, as xneck calibrate wrote it; may be named once for all recordings instead: xneck run --camera"""
    board: str | None = None
    """board.yaml of the pictures from which the camera is calibrated on the way"""
    pictures: str | None = None
    """folder of pictures of the board"""
    angles: str | None = None
    """instead of video and camera: time,alpha1..alphaN[,sigma1..sigmaN] from elsewhere, rad"""
    exposure: Annotated[float, Field(ge=0, le=1)] = 0.0
    """s, how long a frame is exposed"""
    row_time: Annotated[float, Field(ge=-1e-3, le=1e-3)] = 0.0
    """s from row to row of a rolling shutter; where it is not said, the motion of the arm tells it"""
    stamp: Stamp = "middle"
    """which moment of the exposure a frame's time stands for"""
    placement: Literal["believed", "estimated"] = "believed"
    """estimated: the motion tells where the markers sit on their bars"""
    corners: Literal["template", "edges"] = "template"
    """edges: the edges of the markers' squares alone are measured; faster, less exact"""
    anchor: _Rectangle | None = None
    """px, where in the picture the light is that the controller switches and logs as led"""


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


@dataclass(frozen=True)
class SharedFiles:
    """Files that recordings have in common, as a person named them: they take the place of what a recording.yaml names.

    They may lie anywhere, as the person is trusted. What a recording.yaml names lies in its folder.
    """

    neck: Path | None = None
    camera: Path | None = None

    def resolved(self) -> "SharedFiles":
        """With absolute paths, for processes that work elsewhere."""
        return SharedFiles(*(None if path is None else path.resolve() for path in (self.neck, self.camera)))


NOTHING_SHARED = SharedFiles()


def read_recording(folder: str | Path, shared: SharedFiles = NOTHING_SHARED, growing: bool = False) -> Recording:
    """The recording in a folder (or in a recording.yaml itself), with the files that are shared.

    A `growing` one may lack its video and its log yet.

    Raises Refused where keys do not fit together, a file is missing, or a path of recording.yaml leaves the folder.
    """
    folder = Path(folder)
    if not folder.exists():
        raise Refused(folder, "does not exist", "check the name")
    config = folder if folder.is_file() else folder / RECORDING_FILE
    if not config.is_file():
        raise Refused(folder, f"has no {RECORDING_FILE}", "write one with the keys video, log, camera, neck")
    file = read_yaml(config, RecordingFile)
    replaced = {"neck"} if shared.neck else set[str]()
    if shared.camera and file.angles is None:  # in the place of pictures of a board, too
        replaced |= {"camera", "board", "pictures"}
    file = file.model_copy(update=dict.fromkeys(replaced))
    _check_keys(config, file, shared)
    paths = {
        key: _path_inside(config, key, getattr(file, key), must_exist=not (growing and key in _RECORDED))
        for key in _PATH_KEYS
    }
    log, neck, pictures = paths["log"], shared.neck or paths["neck"], paths["pictures"]
    assert log is not None
    assert neck is not None
    if "camera" in replaced:
        paths["camera"] = shared.camera
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


def _check_keys(config: Path, file: RecordingFile, shared: SharedFiles) -> None:
    """Refused where the keys name no arm, no angles and no complete video, or both."""
    if file.neck is None and shared.neck is None:
        raise Refused(config, "names no `neck`", "name the arm's description there, or once for all: --neck neck.yaml")
    if file.angles is None:
        if file.video is None:
            raise Refused(config, "names neither a video nor angles", "give `video` and `camera`, or `angles`")
        if shared.camera is None and (file.camera is None) == (file.board is None or file.pictures is None):
            what = "a video needs `camera`, or `board` and `pictures` to calibrate it"
            raise Refused(config, what, "name one there, or once for all: --camera camera.yaml")
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
