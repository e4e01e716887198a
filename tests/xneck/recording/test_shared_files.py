"""What the command line names may lie anywhere and serves all recordings; what a recording.yaml names stays in its folder."""

import shutil
from pathlib import Path

import pytest

from mechanism.description import read_neck
from mechanism.neck_text import neck_text
from tests.command import run
from tests.paths import SAMPLES
from xneck.recording.fingerprint import fingerprint, refreshed_if_unchanged
from xneck.recording.recording_folder import SharedFiles, read_recording
from xneck.recording.stages import synchronise_recording
from xneck_foundation.errors import Refused

NECK = SAMPLES / "held_out/neck.yaml"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A recording with angles that names no arm."""
    (tmp_path / "monday").mkdir()
    for name in ("angles.csv", "log.mcap"):
        shutil.copy(SAMPLES / "held_out" / name, tmp_path / "monday" / name)
    (tmp_path / "monday/recording.yaml").write_text("angles: angles.csv\nlog: log.mcap\n")
    shutil.copy(NECK, tmp_path / "arm.yaml")
    return tmp_path / "monday"


def test_an_arm_that_is_named_once_serves(folder: Path) -> None:
    arm = folder.parent / "arm.yaml"
    recording = read_recording(folder, SharedFiles(neck=arm))
    assert recording.neck == arm
    assert recording.files["neck"] == arm


def test_it_takes_the_place_of_what_is_named_there(folder: Path) -> None:
    arm = folder.parent / "arm.yaml"
    (folder / "recording.yaml").write_text("angles: angles.csv\nlog: log.mcap\nneck: none.yaml\n")
    with pytest.raises(Refused, match=r"neck: none\.yaml does not exist"):
        read_recording(folder)
    assert read_recording(folder, SharedFiles(neck=arm)).neck == arm


def test_without_it_the_recording_is_refused_with_what_to_do(folder: Path) -> None:
    with pytest.raises(Refused, match=r"names no `neck`.*--neck neck\.yaml"):
        read_recording(folder)


@pytest.mark.parametrize("key", ["log", "angles", "neck"])
def test_a_recording_still_leads_nowhere_out_of_its_folder(key: str, folder: Path) -> None:
    """Neither by a path nor by a link, and not to the very file that the command line names either."""
    arm = folder.parent / "arm.yaml"
    names = {"angles": "angles.csv", "log": "log.mcap", "neck": "neck.yaml"}
    (folder / "link.csv").symlink_to(arm)
    for leads in ("../arm.yaml", "link.csv", str(arm)):
        text = "".join(f"{k}: {leads if k == key else v}\n" for k, v in names.items())
        shutil.copy(NECK, folder / "neck.yaml")
        (folder / "recording.yaml").write_text(text)
        with pytest.raises(Refused, match="leaves the recording's folder"):
            read_recording(folder)
        if key != "neck":
            with pytest.raises(Refused, match="leaves the recording's folder"):
                read_recording(folder, SharedFiles(neck=arm))


def test_a_camera_that_is_named_once_stands_for_a_board_as_well(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text("a: 1\n")
    shared = SharedFiles(camera=tmp_path / "camera.yaml")
    recording = read_recording(SAMPLES / "recording", shared)
    assert (recording.camera, recording.board, recording.pictures) == (tmp_path / "camera.yaml", None, ())
    assert "camera" in recording.files
    # recordings with angles need none
    assert read_recording(SAMPLES / "held_out", shared).camera is None


def test_another_arm_is_noticed(folder: Path) -> None:
    """By the fingerprint, which knows the shared file by its place relative to the recording, and by its content."""
    arm = folder.parent / "arm.yaml"
    recording = read_recording(folder, SharedFiles(neck=arm))
    before = fingerprint(recording)
    assert before["inputs"]["neck"]["file"] == "../arm.yaml"
    assert refreshed_if_unchanged(before, recording) is not None
    arm.write_text(arm.read_text().replace("b: 0.05", "b: 0.051", 1))
    assert refreshed_if_unchanged(before, recording) is None


def test_results_never_take_its_place(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = folder.parent / "results"
    (out / "monday").mkdir(parents=True)
    arm = out / "monday/model.yaml"
    shutil.copy(NECK, arm)
    ran = run(capfd, "run", folder, "--neck", arm, "--out", out)
    assert ran.status == 1
    assert "an input" in ran.err
    assert arm.read_bytes() == NECK.read_bytes()


@pytest.mark.slow
def test_a_data_set_is_made_with_it(folder: Path) -> None:
    data = synchronise_recording(folder, neck=folder.parent / "arm.yaml")
    assert data.neck == read_neck(NECK)
    assert data.clock["offset_sigma_s"] < 1e-3


@pytest.mark.slow
def test_it_reaches_the_processes_of_a_batch(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Each of them refuses an arm of five motors for a log of four."""
    neck = read_neck(NECK)
    more = {"cables": (*neck.cables, neck.cables[0]), "motors": (*neck.motors, neck.motors[0])}
    (folder.parent / "arm.yaml").write_text(neck_text(neck.model_copy(update=more)))
    shutil.copytree(folder, folder.parent / "tuesday")
    out = folder.parent / "results"
    words = (
        "run",
        folder,
        folder.parent / "tuesday",
        "--neck",
        folder.parent / "arm.yaml",
        "--out",
        out,
        "--jobs",
        "1",
    )
    ran = run(capfd, *words)
    assert ran.status == 1
    assert ran.err.count("no channel with 5 joints") == 2, ran.err


def test_watch_takes_them_as_run_does(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Without them the folder is refused; with them it gets as far as the neck.yaml that was named, which is none."""
    (folder / "recording.yaml").write_text("video: video.mkv\nlog: log.csv\n")
    ran = run(capfd, "watch", folder, "--out", tmp_path / "results")
    assert (ran.status, "names no `neck`" in ran.err) == (1, True)
    none = tmp_path / "none.yaml"
    none.write_text("xneck: 1\n")
    ran = run(capfd, "watch", folder, "--neck", none, "--camera", none, "--out", tmp_path / "results")
    assert (ran.status, "none.yaml" in ran.err) == (1, True)


def test_a_folder_that_is_not_there_does_not_lack_a_file(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="monday: does not exist"):
        read_recording(tmp_path / "monday")
