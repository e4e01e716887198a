"""`xneck export` writes the arm as MuJoCo reads it, also signed, and `mujoco_start` puts it into a pose."""

# mujoco comes without complete type stubs
# pyright: reportAttributeAccessIssue=false

from pathlib import Path

import mujoco
import numpy as np
import pytest

import xneck
from identification.model_file import Model, ModelParameter, write_model
from tests.command import run
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused
from xneck_foundation.whole_file import write_text


def model(*laws: str) -> Model:
    names = {"fs": ("N", 15.0), "cm": ("s/rad", 0.5), "k": ("N/m", 9e3), "ca": ("N s/m", 60.0)}
    entries = [
        ModelParameter(
            name=name, index=None, value=value, unit=unit, sigma=None, relative_sigma_percent=None, identified=False
        )
        for name, (unit, value) in names.items()
    ]
    return Model(laws=("dry_friction", "linear_cable", *laws), parameters=tuple(entries))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder as `xneck diagnose` leaves it, as far as the arm goes."""
    made = tmp_path / "diagnosis"
    made.mkdir()
    write_text(made / "neck.yaml", NECK_FILE.read_text())
    write_model(model(), made / "model.yaml")
    return made


def test_the_command_writes_what_mujoco_reads(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "arm.xml"
    ran = run(capfd, "export", folder, "--out", out, "--timestep", "1e-4")
    assert (ran.status, ran.err) == (0, "")
    arm = mujoco.MjModel.from_xml_path(str(out))
    assert (arm.opt.timestep, arm.njnt) == (1e-4, 3 * 3 + 4)
    # the two files themselves say the same
    again = run(capfd, "export", folder / "neck.yaml", folder / "model.yaml", "--out", out, "--timestep", "1e-4")
    assert (again.status, again.err) == (0, "")
    assert mujoco.MjModel.from_xml_path(str(out)).nu == arm.nu


def test_it_begins_where_it_is_told() -> None:
    neck = xneck.read_neck(NECK_FILE)
    alpha, theta = np.array([0.3, -0.2, 0.1]), np.array([10.0, -20.0, 30.0, 5.0])
    bodies = mujoco.MjModel.from_xml_string(xneck.mujoco_model(neck, model()))
    data = mujoco.MjData(bodies)
    for name, value in xneck.mujoco_start(neck, alpha, theta).items():
        data.joint(name).qpos = value
    mujoco.mj_forward(bodies, data)
    assert [data.sensor(f"alpha{i + 1}").data[0] for i in range(3)] == pytest.approx(alpha)
    assert [data.sensor(f"theta{j + 1}").data[0] for j in range(4)] == pytest.approx(theta)
    gaps = [data.site(f"end_B{i + 1}").xpos - data.site(f"top_left{i + 1}").xpos for i in range(3)]
    assert np.abs(gaps).max() < 1e-12


@pytest.mark.parametrize(("alpha", "words"), [([0.1, 0.2], "has the shape"), ([4.0, 0, 0], "singular pose")])
def test_a_pose_that_is_none_is_refused(alpha: list[float], words: str) -> None:
    with pytest.raises(Refused, match=words):
        xneck.mujoco_start(xneck.read_neck(NECK_FILE), alpha)


def test_a_law_without_an_element_is_refused_by_name(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_model(model("cable_creep", "pulley_friction"), folder / "model.yaml")
    ran = run(capfd, "export", folder, "--out", tmp_path / "arm.xml")
    assert (ran.status, len(ran.err.splitlines())) == (1, 1)
    assert "cable_creep: MuJoCo has no element" in ran.err
    assert "pulley_friction: MuJoCo has no friction" in ran.err
    assert not (tmp_path / "arm.xml").exists()
