"""A camera from what people have: picture files, a folder of them, or a video of the board."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from pathlib import Path

from calibration.board import read_board
from calibration.estimation import Calibration, calibrate
from calibration.pictures import Picture, picture_files, read_pictures
from calibration.views import Observations, distinct_views, observe, settled
from vision.video import frames
from xneck_foundation.errors import Refused

VIDEO_SUFFIXES = (".mp4", ".mkv", ".mov", ".avi", ".webm", ".m4v")


def listed(sources: Sequence[Path]) -> list[Path]:
    """Folders replaced by the pictures in them; one video stays alone. Raises Refused for a mixture."""
    files = [file for source in sources for file in (picture_files(source) if source.is_dir() else [source])]
    videos = [file for file in files if file.suffix.lower() in VIDEO_SUFFIXES]
    if videos and len(files) > 1:
        raise Refused(videos[0], "is a video among other files", "give pictures, or one video")
    return files


def calibrate_from(
    files: Sequence[Path],
    board_file: str | Path,
    every: int = 5,
    progress: Callable[[int], object] = lambda pictures: None,
) -> Calibration:
    """Camera from picture files, or from every n-th frame of one video; `progress` is told of each picture looked at."""
    return calibrate(observed(files, board_file, every, progress))


def observed(
    files: Sequence[Path],
    board_file: str | Path,
    every: int = 5,
    progress: Callable[[int], object] = lambda pictures: None,
) -> Observations:
    """What picture files, or every n-th frame of one video (then only views that differ), show of the board."""
    board = read_board(board_file)
    video = len(files) == 1 and files[0].suffix.lower() in VIDEO_SUFFIXES
    pictures = _from_video(files[0], every) if video else read_pictures(files)

    def told() -> Iterator[Picture]:
        for picture in pictures:
            yield picture
            progress(1)

    seen = settled(observe(told(), board))
    return distinct_views(seen) if video else seen


def _from_video(path: Path, every: int) -> Iterator[Picture]:
    for frame in islice(frames(path), 0, None, every):
        yield Picture(f"{path.name} frame {frame.index}", frame.grey.copy())
