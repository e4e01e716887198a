"""docs/json.md says what every key of a record means."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import xneck
from diagnosis.deciding_motion import answers_json, motion_for
from diagnosis.motion_questions import effects_among, questions_about
from identification.design.information import AngleNoise
from identification.design.result import as_json as design_json
from identification.design.search import SearchOptions
from identification.design.trajectory import USUAL_LIMITS
from identification.model_file import machine_of
from mechanism.arm import arm_of
from tests.command import run
from tests.docs.pages import PAGES
from xneck.export.crate_metadata import PackageOptions
from xneck.export.mujoco_file import ArmFiles, write_mujoco_file
from xneck.export.research_object import write_package

NAMED_BY_DATA = {
    "differences_sigma", "files", "inputs", "libraries", "parameters", "recordings", "rms", "settings", "sigma_jackknife",
    "sigma_least_squares", "simulate", "tables",
}  # fmt: skip
"""keys below which there are names of columns, parameters, files and roles; the page says so of each"""
EXAMPLES = {"x01": r"x0\d+"}
"""keys of the page that stand for all of a kind"""


def documented(page: str) -> set[str]:
    """Words in code on the page."""
    return {word for code in re.findall(r"`([^`]+)`", page) for word in re.findall(r"\w+", code)}


def keys(value: Any, below: str = "") -> Iterator[str]:
    """Every key of a record, but for names."""
    if isinstance(value, dict):
        for key, part in value.items():
            is_name = below in NAMED_BY_DATA
            if not is_name:
                yield key
            yield from keys(part, "" if is_name else key)
    elif isinstance(value, list):
        for part in value:
            yield from keys(part)


def undocumented(record: Any, page: str) -> list[str]:
    words = documented(page)
    return sorted(
        key
        for key in set(keys(record))
        if key not in words and not any(re.fullmatch(form, key) for word, form in EXAMPLES.items() if word in words)
    )


@pytest.mark.parametrize("name", ["held_out", "recording"])
def test_keys_of_a_recording(name: str, sample_results: Path) -> None:
    """Of sync, check, identify and simulate, and of result.json: without a video, and of extract with one."""
    record = json.loads((sample_results / name / "result.json").read_text())
    assert ("extract" in record) == (name == "recording")
    assert undocumented(record, PAGES["json.md"]) == []


def test_keys_of_a_calibration(in_examples: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    board, record = in_examples / "samples/recording", tmp_path / "calibration.json"
    words = (board / "board", "--board", board / "board.yaml", "--out", tmp_path / "camera.yaml")
    assert run(capfd, "calibrate", *words, "--json", record).status == 0
    assert undocumented(json.loads(record.read_text()), PAGES["json.md"]) == []


def test_keys_of_results_in_python(in_examples: Path) -> None:
    """Of simulations, a model and a diagnosis."""
    monday, tuesday = xneck.read_dataset("monday.mcap"), xneck.read_dataset("tuesday.mcap")
    model = xneck.read_model("model.yaml")
    motion = xneck.read_motion("motion.csv", monday.neck)
    for result in (
        xneck.simulate(tuesday, model, max_parts=1),
        xneck.simulate_motion(motion, monday.neck, model, source="theta"),
        xneck.diagnose([monday], [tuesday]),
    ):
        assert undocumented(xneck.as_record(result), PAGES["json.md"]) == []


def test_keys_of_a_design(in_examples: Path) -> None:
    neck = xneck.read_neck("samples/recording/neck.yaml")
    machine = machine_of(xneck.read_model("model.yaml"), arm_of(neck))
    effects, parameters = effects_among(["k", "tip_payload"])
    noise, options = AngleNoise(0.002, 30.0), SearchOptions(6.0, draws=1, changes=1, seed=0)
    questions = questions_about(effects, neck, [])
    judged = motion_for(neck, machine, questions, parameters, USUAL_LIMITS, noise, options, lambda _: None)
    record = design_json(judged.designed, USUAL_LIMITS, noise) | {"effects": answers_json(judged)}
    assert undocumented(record, PAGES["json.md"]) == []


def test_keys_of_what_is_exported(in_examples: Path, tmp_path: Path) -> None:
    arm = write_mujoco_file(
        ArmFiles(in_examples / "samples/recording/neck.yaml", in_examples / "model.yaml"), tmp_path / "a.xml"
    )
    package = write_package(in_examples / "samples/held_out", tmp_path / "p.zip", PackageOptions())
    for record in (arm, package):
        assert undocumented(record, PAGES["json.md"]) == []


@pytest.mark.parametrize("key", ["likeness", "rms_motor_N", "as_written"])
def test_a_key_that_lacks_on_the_page_is_noticed(key: str) -> None:
    page = PAGES["json.md"].replace(f"`{key}`", "it")
    assert undocumented({"a": [{key: 1}]}, page) == ["a", key]
    assert undocumented({"rms": {key: 1}}, page) == []
