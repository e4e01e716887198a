"""What editors are told of a file agrees with what is read: right files pass both, wrong values fail both."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft202012Validator

from calibration.board import Board
from mechanism.description import Neck
from mechanism.neck_template import neck_template
from tests.paths import NECK_FILE, SAMPLES
from xneck.recording.recording_folder import RecordingFile
from xneck_foundation.errors import Refused
from xneck_foundation.json_schema import json_schema
from xneck_foundation.strict_yaml import load_yaml, parse_yaml, validate_document

NECK = json_schema(Neck, "neck.yaml")


def faults(schema: dict[str, Any], document: Any) -> list[str]:
    Draft202012Validator.check_schema(schema)
    return [f"{error.json_path}: {error.message}" for error in Draft202012Validator(schema).iter_errors(document)]


@pytest.mark.parametrize("file", sorted(SAMPLES.glob("*/*.yaml")), ids=lambda f: f"{f.parent.name}/{f.name}")
def test_the_samples_have_no_fault(file: Path) -> None:
    kinds = {"neck": Neck, "board": Board, "recording": RecordingFile}
    assert faults(json_schema(kinds[file.stem], file.name), load_yaml(file)) == []


def test_the_file_to_fill_in_has_no_fault() -> None:
    assert faults(NECK, parse_yaml(neck_template(3, 6), "neck.yaml")) == []


def wrong_bar(neck: dict[str, Any]) -> None:
    neck["mechanisms"][1]["b"] = 50


def misspelt(neck: dict[str, Any]) -> None:
    neck["motors"][0]["Rd"] = neck["motors"][0].pop("rd")


def missing(neck: dict[str, Any]) -> None:
    del neck["mechanisms"][2]["springs"]["stiffness"]


def text_for_a_number(neck: dict[str, Any]) -> None:
    neck["mechanisms"][0]["L"] = "0.1"


def no_word_of_a_route(neck: dict[str, Any]) -> None:
    neck["cables"][0]["route"] = ["rigth"]


def another_sign(neck: dict[str, Any]) -> None:
    neck["motors"][3]["theta_sign"] = 2


def three_coordinates(neck: dict[str, Any]) -> None:
    neck["gravity"] = [0.0, 0.0, -9.81]


def no_cable(neck: dict[str, Any]) -> None:
    neck["cables"] = []


def half_a_count(neck: dict[str, Any]) -> None:
    neck["motors"][1]["counts"] = 2048.5


@pytest.mark.parametrize(
    "damage",
    [
        wrong_bar,
        misspelt,
        missing,
        text_for_a_number,
        no_word_of_a_route,
        another_sign,
        three_coordinates,
        no_cable,
        half_a_count,
    ],
    ids=lambda damage: damage.__name__,
)
def test_wrong_values_are_marked_where_they_are_refused(damage: Callable[[dict[str, Any]], None]) -> None:
    document = copy.deepcopy(yaml.safe_load(NECK_FILE.read_text()))
    assert faults(NECK, document) == []
    damage(document)
    assert faults(NECK, document)
    with pytest.raises(Refused):
        validate_document(document, Neck, "neck.yaml")


def test_keys_are_explained() -> None:
    motor = NECK["$defs"]["Motor"]["properties"]
    assert motor["rd"]["description"].startswith("m, radius of the drum")
    assert all(one["description"] for one in motor.values())
