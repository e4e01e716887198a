"""neck.yaml is read strictly: what cannot be built is refused with the place of every fault."""

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.tolerance import Tolerance
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

FILE = NECK_FILE


def changed(tmp_path: Path, **places: Any) -> Path:
    """neck.yaml with values put at dotted places such as mechanisms__0__b."""
    document = copy.deepcopy(yaml.safe_load(FILE.read_text()))
    for place, value in places.items():
        *way, last = [int(part) if part.isdigit() else part for part in place.split("__")]
        target = document
        for part in way:
            target = target[part]
        if value is None:
            del target[last]
        else:
            target[last] = value
    out = tmp_path / "neck.yaml"
    out.write_text(yaml.safe_dump(document))
    return out


def test_the_sample_is_read() -> None:
    neck = read_neck(FILE)
    assert (neck.N, neck.M) == (3, 4)
    assert neck.cables[3].route == ("left_through", "left_through", "left")


@pytest.mark.parametrize(
    ("places", "words"),
    [
        ({"mechanisms__0__b": 50}, ["mechanisms[0].b", "50"]),
        ({"mechanisms__1__L": 100.0, "motors__2__rd": 10.0}, ["mechanisms[1].L", "motors[2].rd"]),
        ({"mechanisms__0__L": 0.04}, ["mechanisms[0]", "exceed b"]),
        ({"mechanisms__0__r": 0.026}, ["mechanisms[0]", "do not fit"]),
        ({"mechanisms__0__L": 0.0502}, ["mechanisms[0]", "do not fit"]),
        ({"mechanisms__0__diagonal__mass": 30.0}, ["diagonal.mass of 30 kg", "is it in g?"]),
        ({"mechanisms__0__top__inertia": 6.25}, ["top.inertia of 6.25", "is it in kg mm^2"]),
        ({"motors__1__f_scale": 0.0}, ["motors[1].f_scale: must not be 0"]),
        ({"motors__0__Ia": 0.0}, ["motors[0].Ia: expected greater than 0, found 0.0"]),
        ({"mechanisms__0__mass": 1.0}, ["mechanisms[0].mass: unknown key"]),
        (
            {"mechanisms__1__stiffness": 400.0},
            ["mechanisms[1].stiffness: unknown key here, it belongs to mechanisms[].springs"],
        ),
        ({"motors__0__size": 0.03}, ["motors[0].size: unknown key here, it belongs to markers"]),
        ({"at": [0, 0]}, ["at: unknown key here, it belongs to markers.on_bars[]"]),
        ({"mechanisms__2__springs__stiffness": None}, ["mechanisms[2].springs.stiffness: missing"]),
        ({"cables__0__route": ["upwards"]}, ["cables[0].route[0]", "'right'"]),
        ({"cables__1__route": ["right", "right"]}, ["cables[1]", "only be the last"]),
        ({"cables__1__route": ["strut", "left"]}, ["cables[1]", "right side"]),
        ({"cables__1__route": ["strut"] * 4}, ["cables[1].route crosses 4 mechanisms of 3"]),
        ({"motors__3": None}, ["neck.yaml: motors: 3 motors for 4 cables"]),
        ({"mechanisms__0__b": 50}, ["found 50: is it in mm?"]),
        ({"mechanisms__0__b": 50_000}, ["found 50000; all in SI"]),
        ({"cables__0__section": 0.79}, ["found 0.79: is it in mm^2?"]),
        ({"cables__0__section": 1e-12}, ["expected greater than or equal to 1e-9, found 1e-12"]),
        ({"markers__on_bars__1__angle": 90}, ["expected less than or equal to 3.14159, found 90: is it in deg?"]),
        ({"mechanisms__0__b": "0,05"}, ["found '0,05': write 0.05"]),
        ({"mechanisms__0__b": "nan"}, ["found 'nan'; all in SI"]),
        ({"markers__on_bars__2__diagonal": "1"}, ["found '1'; all in SI"]),
        ({"gravity": [0, 0, -9, 81]}, ["gravity: expected at most 2, found 4, as decimal commas make of it"]),
        ({"gravity": [0, "\N{MINUS SIGN}9.81"]}, ["gravity[1]", "write -9.81"]),
        ({"mechanisms__0__springs__slack": "no"}, ["expected true or false, found 'no'"]),
        ({"mechanisms__0__b": "1/20", "mechanisms__2__b": "1/20"}, ["found '1/20' (and in 1 other); all in SI"]),
        (
            {"cables__0__rute": ["right"], "cables__0__route": None},
            ["cables[0].rute: unknown key, did you mean route?"],
        ),
        ({"cables__0__route": ["rigth"]}, ["cables[0].route[0]", "found 'rigth', did you mean right?"]),
        ({"markers__on_bars__2__bar": 7}, ["on_bars[2].bar is 7", "0..3"]),
        ({"markers__on_bars__2__diagonal": "A1"}, ["on_bars[2]", "found bar: 2 and diagonal: A1"]),
        ({"markers__on_bars__2__bar": None}, ["on_bars[2]", "either `bar` or `diagonal`, found neither"]),
        (
            {"markers__on_bars__2__bar": None, "markers__on_bars__2__diagonal": "B4"},
            ["on_bars[2].diagonal is B4", "1..3"],
        ),
        ({"markers__on_bars__2__diagonal": "C1"}, ["on_bars[2].diagonal", "C1"]),
        ({"markers__on_bars__2__id": 0}, ["neck.yaml: markers.on_bars: id 0 stands twice, in [0] and [2]"]),
        ({"motors__0__theta_sign": 2}, ["motors[0].theta_sign"]),
        ({"mechanisms__0__b": "0.05"}, ["mechanisms[0].b", "number"]),
        ({"xneck": 2}, ["xneck"]),
        (
            {"mechanisms__1__springs__free_length": 3.1},
            ["mechanisms[1]: springs.free_length of 3.1 m is", "which no side is longer than: is it in cm or mm?"],
        ),
        ({"tolerance": {"masses": 0.02}}, ["tolerance.masses: unknown key, did you mean mass?"]),
        ({"tolerance": {"tilt": 0.3}}, ["tolerance.tilt: 0.3 rad are 17.2 deg; if 0.3 deg are meant, write 0.00524"]),
        ({"gravity": [0.0, 0.0, -9.81]}, ["gravity: expected at most 2, found 3"]),
        ({"motors__0__thetaSign": 1}, ["motors[0].thetaSign: unknown key, theta_sign is there already, leave one out"]),
        ({"tolerance": {"drum": -0.01}}, ["tolerance.drum", "-0.01"]),
        ({"mechanisms__0__springs__right": {"stiffness": 50.0}}, ["mechanisms[0].springs.right.free_length: missing"]),
        (
            {"mechanisms__0__springs__right": {"stiffness": 50.0, "free_length": 0.02, "slack": True}},
            ["mechanisms[0].springs.right.slack: unknown key"],
        ),
    ],
)
def test_faults_are_refused_with_their_places(tmp_path: Path, places: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(Refused) as caught:
        read_neck(changed(tmp_path, **places))
    for word in words:
        assert word in str(caught.value)


def test_markers_may_be_absent(tmp_path: Path) -> None:
    assert read_neck(changed(tmp_path, markers=None)).markers is None


def test_a_tolerance_that_is_given_is_read_and_the_others_are_a_workshops(tmp_path: Path) -> None:
    assert read_neck(FILE).tolerance == Tolerance()
    found = read_neck(changed(tmp_path, tolerance={"drum": 0.0, "tilt": 0.1})).tolerance
    assert found == Tolerance(drum=0.0, tilt=0.1)
    assert found.mass == Tolerance().mass > 0


def test_a_right_spring_may_be_another_one(tmp_path: Path) -> None:
    """The others are alike on both sides."""
    place = {"mechanisms__1__springs__right": {"stiffness": 321.0, "free_length": 0.031}}
    arm, was = arm_of(read_neck(changed(tmp_path, **place))), arm_of(read_neck(FILE))
    assert (arm.spring_stiffness[1, 1], arm.spring_free_length[1, 1]) == (321.0, 0.031)
    assert (arm.spring_stiffness[0] == was.spring_stiffness[0]).all()
    assert (arm.spring_stiffness[1, [0, 2]] == was.spring_stiffness[0, [0, 2]]).all()


def test_a_key_that_is_misspelt_everywhere_is_all_that_is_said(tmp_path: Path) -> None:
    """Not that no mechanism is left when all are at fault."""
    path = tmp_path / "neck.yaml"
    path.write_text(FILE.read_text().replace("stiffness", "stifness"))
    with pytest.raises(Refused) as caught:
        read_neck(path)
    first = "mechanisms[0].springs.stifness: unknown key, did you mean stiffness?"
    assert caught.value.what == f"{first} (and in 2 others)"


def test_one_mechanism_too_few_is_one_fault(tmp_path: Path) -> None:
    """Though three cables and a marker need the third."""
    with pytest.raises(Refused) as caught:
        read_neck(changed(tmp_path, mechanisms__2=None))
    text = str(caught.value)
    assert "mechanisms: 2 are too few, in 3 places: cables[2].route crosses 3 mechanisms of 2; all in SI" in text
