"""What a newcomer gets wrong is answered in one line, exit 1, and nothing half-written is left."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from calibration.camera import camera_from
from calibration.camera_file import write_camera
from samples.generator.camera import SAMPLE_CAMERA
from samples.generator.video import render_video
from tests.command import run
from tests.paths import SAMPLES
from tests.vision.linkage.test_linkage_fit import camera
from xneck.cli import main

R, H = SAMPLES / "recording", SAMPLES / "held_out"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with a camera.yaml and an empty folder `out` for results."""
    write_camera(camera(), tmp_path / "camera.yaml")
    (tmp_path / "out").mkdir()
    return tmp_path


def extract(place: Path, video: Path, neck: Path = R / "neck.yaml") -> list[str | Path]:
    return ["extract", video, "--camera", place / "camera.yaml", "--neck", neck, "--out", place / "out/angles.mcap"]


def sync(place: Path, angles: Path, log: Path, neck: Path = R / "neck.yaml") -> list[str | Path]:
    return ["sync", angles, log, "--neck", neck, "--out", place / "out/dataset.mcap"]


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def missing_video(place: Path) -> list[str | Path]:
    return extract(place, place / "none.mp4")


def text_named_mp4(place: Path) -> list[str | Path]:
    return extract(place, written(place / "v.mp4", "not a video at all\n" * 50))


def truncated_mp4(place: Path) -> list[str | Path]:
    whole = (R / "video.mp4").read_bytes()
    (place / "v.mp4").write_bytes(whole[: len(whole) // 2])
    return extract(place, place / "v.mp4")


def video_without_a_marker(place: Path) -> list[str | Path]:
    bare = yaml.safe_load((R / "neck.yaml").read_text())
    del bare["markers"]
    small = SAMPLE_CAMERA.scaled(0.25)
    render_video(place / "v.mp4", np.arange(6) / 30, lambda t: np.zeros((*np.shape(t), 3)), bare, small, seed=0)
    parameters = np.array([small.fx, small.fy, small.cx, small.cy, small.k1, small.k2, small.p1, small.p2, small.k3])
    write_camera(camera_from(parameters, (small.width, small.height)), place / "camera.yaml")
    return extract(place, place / "v.mp4")


def bar_of_fifty_metres(place: Path) -> list[str | Path]:
    text = (R / "neck.yaml").read_text().replace("b: 0.05", "b: 50", 1)
    return extract(place, R / "video.mp4", written(place / "neck.yaml", text))


def columns(place: Path, header: Callable[[list[str]], list[str]]) -> Path:
    lines = (R / "log.csv").read_text().splitlines()
    return written(place / "log.csv", "\n".join([",".join(header(lines[0].split(","))), *lines[1:]]))


def missing_column(place: Path) -> list[str | Path]:
    return sync(place, H / "angles.csv", columns(place, lambda h: [name.replace("f3", "g3") for name in h]))


def swapped_theta(place: Path) -> list[str | Path]:
    turn = {"theta1": "theta2", "theta2": "theta1"}
    return sync(place, true_angles(place), columns(place, lambda h: [turn.get(name, name) for name in h]))


def theta_for_force(place: Path) -> list[str | Path]:
    turn = {"theta1": "f1", "f1": "theta1"}
    return sync(place, true_angles(place), columns(place, lambda h: [turn.get(name, name) for name in h]))


def log_of_another_time(place: Path) -> list[str | Path]:
    return sync(place, true_angles(place), H / "log.mcap")


def angles_in_degrees(place: Path) -> list[str | Path]:
    table = np.genfromtxt(H / "angles.csv", delimiter=",", names=True)
    rows = [
        ",".join([repr(float(r["time"])), *(repr(float(np.degrees(r[f"alpha{i}"]))) for i in (1, 2, 3))]) for r in table
    ]
    return sync(place, written(place / "a.csv", "\n".join(["time,alpha1,alpha2,alpha3", *rows])), H / "log.mcap")


def log_without_a_whole_chunk(place: Path) -> list[str | Path]:
    whole = (R / "log.mcap").read_bytes()
    (place / "log.mcap").write_bytes(whole[: len(whole) // 5])
    return sync(place, H / "angles.csv", place / "log.mcap")


def too_little_of_a_log(place: Path) -> list[str | Path]:
    """Its first half, and angles of a time after that."""
    whole = (H / "log.mcap").read_bytes()
    (place / "log.mcap").write_bytes(whole[: len(whole) // 2])
    rows = (H / "angles.csv").read_text().splitlines()
    return sync(
        place, written(place / "a.csv", "\n".join([rows[0], *rows[-290:]])), place / "log.mcap", H / "neck.yaml"
    )


def time_that_jumps_back(place: Path) -> list[str | Path]:
    lines = (R / "log.csv").read_text().splitlines()
    return sync(place, H / "angles.csv", written(place / "log.csv", "\n".join(lines[:500] + lines[100:900])))


def two_pictures_for_a_camera(place: Path) -> list[str | Path]:
    pictures = [R / "board/01.jpg", R / "board/02.jpg"]
    return ["calibrate", *pictures, "--board", R / "board.yaml", "--out", place / "out/camera.yaml"]


def results_into_nowhere(place: Path) -> list[str | Path]:
    return [
        "sync",
        H / "angles.csv",
        H / "log.mcap",
        "--neck",
        H / "neck.yaml",
        "--out",
        place / "nowhere/dataset.mcap",
    ]


def folder_without_recording(place: Path) -> list[str | Path]:
    return ["run", place, "--out", place / "out"]


def recording_that_leaves_its_folder(place: Path) -> list[str | Path]:
    written(place / "recording.yaml", "angles: ../a.csv\nlog: ../log.csv\nneck: ../neck.yaml\n")
    return ["run", place, "--out", place / "out"]


def export_of_a_folder_that_is_not_there(place: Path) -> list[str | Path]:
    return ["export", place / "nonexist", "--out", place / "out/arm.xml"]


def true_angles(place: Path) -> Path:
    """The main recording's angles as a CSV, so that only the log is at fault."""
    stored = np.load(SAMPLES / "truth.npz")
    table = np.column_stack([stored["recording_frame_times"], stored["recording_frame_alpha"]])
    np.savetxt(place / "true.csv", table, delimiter=",", header="time,alpha1,alpha2,alpha3", comments="", fmt="%.9g")
    return place / "true.csv"


CASES: dict[Callable[[Path], list[str | Path]], str] = {
    missing_video: r"none\.mp4: does not exist",
    text_named_mp4: r"v\.mp4: is no video in mp4, mov, mkv",
    truncated_mp4: r"v\.mp4: is truncated",
    video_without_a_marker: r"v\.mp4: no marker of neck\.yaml was found in 6 frames",
    bar_of_fifty_metres: r"neck\.yaml: mechanisms\[0\]\.b: expected .* 2, found 50.*SI units",
    missing_column: r"log\.csv: lacks the column f3",
    swapped_theta: r"theta1 and theta2 are swapped",
    theta_for_force: r"cable 1 contradicts all others.*is it f1",
    log_of_another_time: r"do not show the same motion.*overlap",
    angles_in_degrees: r"a\.csv: .*radians",
    log_without_a_whole_chunk: r"log\.mcap: not one row of it can be read: is cut off",
    too_little_of_a_log: r"the same motion .*log\.mcap: is cut off; /joint_states has \d+ rows",
    time_that_jumps_back: r"log\.csv: time jumps back in row 501",
    two_pictures_for_a_camera: r"2",
    results_into_nowhere: r"nowhere does not exist",
    folder_without_recording: r"recording\.yaml",
    export_of_a_folder_that_is_not_there: r"nonexist: does not exist; check the name",
    recording_that_leaves_its_folder: r"leaves the recording's folder",
}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.__name__)
def test_one_line_exit_one_and_nothing_left(
    case: Callable[[Path], list[str | Path]], place: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    status, out, err = run(capfd, *case(place))
    assert status == 1
    assert out == ""
    assert err.count("\n") == 1, err
    assert re.search(CASES[case], err), err
    assert [p for p in (place / "out").rglob("*") if p.is_file()] == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["idenify", "x"], "no command 'idenify'; did you mean identify?"),
        (["synchronise"], "no command 'synchronise'; did you mean sync?"),
        (["nonsense"], "no command 'nonsense'; valid: init, "),
        (["sync", "a", "b", "--nek", "c"], "--neck"),
        (["x\x1b[31m" * 300], r"no command 'x\x1b[31m"),
        (["sync", "--\x1b[31m" * 300], r"\x1b[31m"),
    ],
)
def test_wrong_usage_says_what_was_meant(words: list[str], says: str, capfd: pytest.CaptureFixture[str]) -> None:
    status, out, err = run(capfd, *words)
    assert (status, out) == (2, "")
    assert says in err
    assert all(line.isprintable() and len(line) < 500 for line in err.splitlines()), err


NECK, BOARD, LIST = R / "neck.yaml", R / "board.yaml", R / "recording.yaml"
ARM = "is the description of an arm (neck.yaml)"


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["show", BOARD], "is a calibration board (board.yaml), not the description of an arm; give a neck.yaml here"),
        (["show", LIST], "is the list of a recording's files (recording.yaml), not the description of an arm"),
        (["show", "model.yaml"], "is a model of `xneck identify` (model.yaml), not the description of an arm"),
        (["export", NECK, NECK], f"{ARM}, not a model of `xneck identify`; give a model.yaml here"),
        (["extract", R / "video.mp4", "--neck", NECK, "--camera", NECK], f"{ARM}, not the calibration of a camera"),
        (["calibrate", R / "board", "--board", NECK], f"{ARM}, not a calibration board; give a board.yaml here"),
        (["board", "camera.yaml"], "is the calibration of a camera (camera.yaml), neither a board.yaml"),
        (["run", "folder"], f"{ARM}, not the list of a recording's files; give a recording.yaml here"),
    ],
    ids=lambda value: " ".join(Path(word).name for word in value) if isinstance(value, list) else "",
)
def test_a_file_in_the_place_of_another_is_named_by_what_it_is(
    words: list[str | Path], says: str, place: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(place)
    written(place / "model.yaml", "xneck_model: 1\nlaws: []\nparameters: []\n")
    (place / "folder").mkdir()
    written(place / "folder/recording.yaml", NECK.read_text())
    out = (
        "out" if words[0] == "run" else {"board": "out.pdf", "export": "out.xml", "show": "out.svg"}.get(str(words[0]))
    )
    status, _, err = run(capfd, *words, "--out", out or "out.yaml")
    assert (status, err.count("\n")) == (1, 1)
    assert says in err


NASTY = "n\x1b[31m\nm\x9b.csv"
"""a file's name that would turn a terminal red"""


def test_names_of_files_reach_no_terminal_raw(place: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Neither in a refusal, nor in a warning, nor in the lines of a result."""
    (place / NASTY).write_text("time,alpha1\n0,0\n")
    refused = run(capfd, *sync(place, place / NASTY, H / "log.mcap"))
    assert refused.status == 1
    assert r"n\x1b[31m\nm\x9b.csv: lacks the columns alpha2, alpha3; its header is" in refused.err
    out = place / f"out/{NASTY}.svg"
    done = run(capfd, "board", R / "board.yaml", "--out", out)
    assert done.status == 0, done
    assert r"m\x9b.csv.svg: board on" in done.out
    for text in (refused.err, done.out):
        assert all(line.isprintable() for line in text.splitlines())


@pytest.mark.parametrize("words", [["init", "--out"], ["demo", "--out"]])
def test_a_dash_is_no_name_of_a_file(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ran = run(capfd, *words, "-")
    assert ran.status == 2
    assert "only --json goes to standard output: give a" in ran.err
    assert not list(tmp_path.iterdir())


def test_wrong_usage_is_two_and_help_has_an_example(capfd: pytest.CaptureFixture[str]) -> None:
    assert run(capfd, "extract").status == 2
    assert run(capfd, "nonsense").status == 2
    names = "init show logs board calibrate extract sync check identify simulate design run demo"
    for name in names.split():
        shown = run(capfd, name, "--help")
        assert shown.status == 0
        assert f"Example: xneck {name}" in shown.out


def test_a_name_that_is_not_utf_8_is_refused_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All was computed, and then the report could not be written."""
    monkeypatch.setattr("sys.argv", ["xneck", "run", "M\udcfcller", "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    assert capsys.readouterr().err == (
        "xneck: M\\xfcller: is not written in UTF-8, as a name of an old disk or archive; rename it\n"
    )
    assert not (tmp_path / "out").exists()
