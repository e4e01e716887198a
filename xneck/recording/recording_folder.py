"""A recording folder: recording.yaml and the files it names."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from calibration.pictures import picture_files
from vision.light_patch import LightPatch
from vision.linkage.shared_fit import PlacementPrior
from vision.shutter import Shutter, Stamp
from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import Strict, read

NAME = "recording.yaml"


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
    placement: PlacementPrior | None
    """to estimate where the markers sit; None believes neck.yaml"""
    template: bool
    """whether corners are fitted to all grey levels of a marker, rather than to its edges"""
    light: LightPatch | None
    """where in the video a light is seen that the controller switches and logs as `led`"""

    @property
    def files(self) -> dict[str, Path]:
        """What is read of it, by role; recording.yaml apart."""
        out = {"neck": self.neck, "log": self.log}
        if self.angles is not None:
            return out | {"angles": self.angles}
        assert self.video is not None
        if self.camera is not None:
            out["camera"] = self.camera
        else:
            assert self.board is not None
            out["board"] = self.board
            out |= {f"picture {path.name}": path for path in self.pictures}
        return out | {"video": self.video}


def read_recording(folder: str | Path) -> Recording:
    """The recording in a folder (or in a recording.yaml itself).

    Raises Refused where keys do not fit together, a file is missing, or a path leaves the folder.
    """
    folder = Path(folder)
    config = folder if folder.is_file() else folder / NAME
    if not config.is_file():
        raise Refused(folder, f"has no {NAME}", "write one with the keys video, log, camera, neck")
    folder = config.parent
    file = read(config, _File)
    if file.angles is None:
        if file.video is None:
            raise Refused(config, "names neither a video nor angles", "give `video` and `camera`, or `angles`")
        if (file.camera is None) == (file.board is None or file.pictures is None):
            raise Refused(config, "a video needs `camera`, or `board` and `pictures` to calibrate it")
    elif file.video or file.camera:
        raise Refused(config, "names both angles and a video", "leave one of them out")

    def inside(key: str, value: str | None) -> Path | None:
        if value is None:
            return None
        path = folder / value
        try:
            real, there = Path(os.path.realpath(path)), path.exists()
        except (OSError, ValueError) as error:
            raise Refused(config, f"{key}: {value!r} is no file's name", "check the name") from error
        if not real.is_relative_to(os.path.realpath(folder)):
            raise Refused(config, f"{key}: {value} leaves the recording's folder", "keep its files inside")
        if not there:
            raise Refused(config, f"{key}: {value} does not exist", "check the name")
        return path

    paths = {
        key: inside(key, value)
        for key, value in file.model_dump(
            exclude={"exposure", "row_time", "stamp", "placement", "corners", "anchor"}
        ).items()
    }
    pictures = paths.pop("pictures")
    listed = () if pictures is None else tuple(picture_files(pictures))
    log, neck = paths.pop("log"), paths.pop("neck")
    assert log is not None
    assert neck is not None
    shutter = Shutter(file.exposure, file.row_time, file.stamp)
    prior = PlacementPrior() if file.placement == "estimated" else None
    return Recording(
        folder,
        config,
        log,
        neck,
        pictures=listed,
        shutter=shutter,
        placement=prior,
        template=file.corners == "template",
        light=LightPatch(**file.anchor.model_dump()) if file.anchor else None,
        **paths,
    )
