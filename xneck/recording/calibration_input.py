"""The input of a calibration: picture files of a board, a folder of them, or a video of it."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from pathlib import Path

from calibration.board import read_board
from calibration.estimation import Calibration, calibrate
from calibration.observations import Observations, distinct_views, observe_board, without_hidden_corners
from calibration.pictures import Picture, picture_files, read_pictures
from vision.video import read_frames
from xneck_foundation.errors import Refused

VIDEO_SUFFIXES = (".mp4", ".mkv", ".mov", ".avi", ".webm", ".m4v", ".ts", ".mts", ".m2ts", ".mpg", ".mpeg", ".3gp")


def list_board_files(sources: Sequence[Path]) -> list[Path]:
    """All picture files, with folders replaced by the pictures in them, or one video.

    Raises Refused for a video among other files.
    """
    files = [file for source in sources for file in (picture_files(source) if source.is_dir() else [source])]
    videos = [file for file in files if _is_video(file)]
    if videos and len(files) > 1:
        raise Refused(videos[0], "is a video among other files", "give pictures, or one video")
    return files


def calibrate_from_files(
    files: Sequence[Path],
    board_file: str | Path,
    every: int = 5,
    progress: Callable[[int], object] = lambda pictures: None,
) -> Calibration:
    """The camera from picture files, or from every n-th frame of one video.

    `progress` is called with 1 after each picture.
    """
    return calibrate(observe_board_files(files, board_file, every, progress))


def observe_board_files(
    files: Sequence[Path],
    board_file: str | Path,
    every: int = 5,
    progress: Callable[[int], object] = lambda pictures: None,
) -> Observations:
    """The board's corners in picture files, or in every n-th frame of one video, of which only views that differ are kept.

    `progress` is called with 1 after each picture.
    """
    board = read_board(board_file)
    video = len(files) == 1 and _is_video(files[0])
    pictures = _video_pictures(files[0], every) if video else read_pictures(files)

    def counted() -> Iterator[Picture]:
        for picture in pictures:
            yield picture
            progress(1)

    observations = without_hidden_corners(observe_board(counted(), board))
    return distinct_views(observations) if video else observations


def _is_video(file: Path) -> bool:
    return file.suffix.lower() in VIDEO_SUFFIXES


def _video_pictures(path: Path, every: int) -> Iterator[Picture]:
    """Every n-th frame of a video as a picture of its own."""
    for frame in islice(read_frames(path), 0, None, every):
        yield Picture(f"{path.name} frame {frame.index}", frame.grey.copy())
