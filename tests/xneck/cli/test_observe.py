"""xneck observe on the sample: identified with a camera on one recording, told by the motors alone on another."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import xneck
from identification.files import joint_state
from synchronisation.encoder_log import read_log
from tests.command import run
from tests.paths import SAMPLES

R, H = SAMPLES / "recording", SAMPLES / "held_out"
STORED = np.load(SAMPLES / "truth.npz")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording without a video, as a data set and a model."""
    import subprocess
    import sys

    folder = tmp_path_factory.mktemp("observe")
    xneck.write_dataset(xneck.synchronise(H), folder / "dataset.mcap")
    words = ["identify", "dataset.mcap", "--out", "model.yaml"]
    call = [sys.executable, "-m", "xneck", *words]
    done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return folder


def words(made: Path, out: Path, log: Path = R / "log.mcap") -> list[str | Path]:
    return ["observe", log, "--neck", H / "neck.yaml", "--model", made / "model.yaml", "--out", out]


def test_another_recordings_joints_are_told_within_a_third_of_a_degree(
    made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """With 100 g on the tip that the description lacks: sigma is no smaller than half of the error."""
    out = tmp_path / "state.mcap"
    ran = run(capfd, *words(made, out), "--json", tmp_path / "state.json", "--export", "c")
    assert (ran.status, ran.err) == (0, "")
    assert "sigma of the joints" in ran.out
    state = joint_state.as_series(joint_state.read(out).logs["state"])
    for suffix, limit in (("", 0.33), ("_d", 1.5)):
        true = STORED[f"recording_alpha{suffix}"]
        true = np.stack([np.interp(state.time, STORED["recording_log_time"], c) for c in true.T], axis=-1)
        error = (state.matrix("alpha", suffix) - true)[500:]
        assert np.degrees(np.sqrt(np.mean(error**2, axis=0))).max() < limit
        assert np.sqrt(np.mean((error / state.matrix("sigma_alpha", suffix)[500:]) ** 2)) < 2
    record = json.loads((tmp_path / "state.json").read_text())
    assert record["rows"] == len(state)
    assert record["health"]["verdict"] in ("as identified", "changed")
    assert "xneck_observer_step" in (tmp_path / "state.c").read_text()
    assert run(capfd, *words(made, out), "--export", "c", "--quiet").status == 0  # its own file may be replaced


def rare_frames(folder: Path, unit: float = 1.0, late: float = 0.0) -> Path:
    """A frame every two seconds of the recording, as a CSV whose times are so many units of a second, and so late."""
    time = np.arange(STORED["recording_log_time"][0], STORED["recording_log_time"][-1], 2.0)
    columns = [np.interp(time, STORED["recording_log_time"], c) for c in STORED["recording_alpha"].T]
    path = folder / f"frames_{unit:g}_{late:g}.csv"
    rows = np.stack([unit * time + late, *columns], axis=1)
    np.savetxt(path, rows, "%.9g", delimiter=",", header="time,alpha1,alpha2,alpha3", comments="")
    return path


def test_frames_may_be_seconds_apart(made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out, frames = tmp_path / "state.csv", rare_frames(tmp_path)
    ran = run(capfd, *words(made, out), "--angles", frames, "--json", tmp_path / "state.json", "--quiet")
    assert (ran.status, ran.err) == (0, "")
    assert json.loads((tmp_path / "state.json").read_text())["frames_used"] == len(frames.read_text().splitlines()) - 1


def test_rows_that_repeat_one_sample_are_a_gap(made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A second in which the controller wrote the same row again, angles and forces, while the arm moved on."""
    head, *lines = (R / "log.csv").read_text().splitlines()
    held = [line.split(",", 1)[0] + "," + lines[2000].split(",", 1)[1] for line in lines[2001:2500]]
    log, out = tmp_path / "log.csv", tmp_path / "state.csv"
    log.write_text("\n".join([head, *lines[:2001], *held, *lines[2500:5000]]) + "\n")
    ran = run(capfd, *words(made, out, log), "--json", tmp_path / "state.json", "--quiet")
    assert ran.status == 0
    assert "499 rows repeat the one before" in ran.err
    record = json.loads((tmp_path / "state.json").read_text())
    assert (record["rows"], record["restarts"]) == (5000 - 499, 1)


def test_what_cannot_be_observed_is_refused_in_one_line(
    made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    log.write_text("time,theta1,theta2,theta3,theta4\n" + "".join(f"{0.002 * i:.3f},0,0,0,0\n" for i in range(50)))
    for more, found in (
        (words(made, tmp_path / "s.mcap", log), "holds no forces"),
        ([*words(made, tmp_path / "s.mcap"), "--start", "0.1,0"], "--start: 2 angles for 3 joints"),
        (words(made, tmp_path / "s.xml"), "unknown suffix"),
        ([*words(made, tmp_path / "s.mcap"), "--angles", H / "log.mcap"], "camera's own clock"),
        ([*words(made, tmp_path / "s.mcap"), "--angles", rare_frames(tmp_path, 1e3)], "time is in milliseconds"),
        (
            [*words(made, tmp_path / "s.mcap"), "--angles", rare_frames(tmp_path, 1.0, 1e5)],
            "100 % of its frames are not within",
        ),
        (
            [*words(made, tmp_path / "s.mcap"), "--start", "a,b,c"],
            "'a,b,c' is no list of numbers; write numbers in rad",
        ),
        ([*words(made, tmp_path / "s.mcap"), "--start", "nan"], "nan rad is not within +-180 deg"),
        (words(made, R / "log.mcap"), "is an input too"),
        (words(made, tmp_path / "s.mcap", H / "angles.csv"), "holds joint angles, not the motors' log"),
        (
            ["sync", R / "log.csv", H / "angles.csv", "--neck", H / "neck.yaml", "--out", tmp_path / "d.mcap"],
            "not joint angles",
        ),
    ):
        ran = run(capfd, *more)
        assert (ran.status, ran.out) == (1, ""), more
        assert found in ran.err
        assert ran.err.count("\n") == 1


def test_a_file_that_somebody_else_wrote_is_kept(made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "state.c").write_text("int main(void) { return 0; }\n")
    ran = run(capfd, *words(made, tmp_path / "state.mcap"), "--export", "c")
    assert ran.status == 1
    assert "is not as xneck wrote it" in ran.err
    assert not (tmp_path / "state.mcap").exists()


def test_from_python_it_has_words_and_a_record(made: Path) -> None:
    neck = xneck.read_neck(H / "neck.yaml")
    log = read_log(R / "log.mcap", neck)
    observed = xneck.observe(neck, xneck.read_model(made / "model.yaml"), log.part(np.arange(len(log)) < 1500))
    record = xneck.as_record(observed)
    assert record["rows"] == 1500
    assert record["sigma_alpha_rms_rad"] == pytest.approx(
        np.sqrt(np.mean(observed.series.matrix("sigma_alpha") ** 2, axis=0))
    )
    head, *lines = xneck.in_words(observed).splitlines()
    shown = [float(s) for s in head.split("sigma of the joints ")[1].split(" deg")[0].split(", ")]
    np.testing.assert_allclose(shown, np.degrees(record["sigma_alpha_rms_rad"]), atol=6e-4)
    assert all(line.startswith("  ") for line in lines)


def test_the_description_of_another_arm_than_the_calibrated_one_is_named(
    made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A drawing that was corrected; how the log is written does not matter."""
    text = (H / "neck.yaml").read_text()
    (tmp_path / "neck.yaml").write_text(text.replace("-9.81", "-9.80", 1))
    given = words(made, tmp_path / "state.csv")
    given[given.index("--neck") + 1] = tmp_path / "neck.yaml"
    ran = run(capfd, *given)
    assert ran.status == 0
    assert "describes another arm than the one that" in ran.err


@pytest.mark.parametrize("described", ["as calibrated", "otherwise"])
def test_a_simulation_names_the_description_of_another_arm(
    described: str, made: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    data = xneck.read_dataset(made / "dataset.mcap")
    if described == "otherwise":
        text = data.neck_yaml.replace("-9.81", "-9.80", 1)
        xneck.write_dataset(replace(data, neck_yaml=text), tmp_path / "dataset.mcap")
    file = (made if described == "as calibrated" else tmp_path) / "dataset.mcap"
    ran = run(capfd, "simulate", file, "--model", made / "model.yaml", "--out", tmp_path / "simulated.mcap")
    assert ran.status == 0
    assert ("describes another arm than the one that" in ran.err) == (described == "otherwise")
