"""Angles that a camera saw now and then while a log was written, on the log's clock."""

from pathlib import Path

from identification.dataset.dataset_file import read_dataset
from identification.dataset.frames import FrameAngles, frame_angles
from identification.dataset.same_log import check_same_log
from identification.dataset.series import Series
from identification.dataset.time_unit import check_times_on_log
from identification.files import joint_state
from mechanism.description import Neck
from synchronisation.angles import read_angles
from xneck_foundation.errors import Refused


def read_frames_on_log(path: str | Path, neck: Neck, log: Series) -> FrameAngles:
    """The frames of a data set, whose clock is known, or of a CSV `time,alpha1..N[,sigma1..N]` whose times are the log's.

    Raises Refused where the file is an angles.mcap, which is on the camera's clock, of another arm, or made with another log, and
    where no frame is within the log's times.
    """
    path = Path(path)
    frames = _frames_of_csv(path, neck) if path.suffix.lower() != ".mcap" else _frames_of_dataset(path, neck.N, log)
    check_times_on_log(frames.time, log.time, str(path))
    return frames


def _frames_of_csv(path: Path, neck: Neck) -> FrameAngles:
    angles = read_angles(path, neck.N, filmed=False).from_zero(neck.zero_angles)
    return FrameAngles(angles.time, angles.alpha, angles.white_sigma, angles.shared)


def _frames_of_dataset(path: Path, joints: int, log: Series) -> FrameAngles:
    file = joint_state.read(path)
    file.refuse_faulty(path, "state")
    if "state" not in file.logs:
        raise Refused(path, "is on the camera's own clock", "give the data set that `xneck sync` makes of it")
    data = read_dataset(path)
    frames = frame_angles(data)
    if frames.alpha.shape[1] != joints:
        raise Refused(path, f"has {frames.alpha.shape[1]} angles, the arm has {joints}", "is it the right neck.yaml?")
    check_same_log(data, log, str(path))
    return frames
