"""Topics as other programs record them: what they lack is said by its true reason."""

from pathlib import Path

import numpy as np
import pytest

from identification.files.joint_state_channel import JointStateChannel
from synchronisation.log_contents import LogContents
from synchronisation.log_mapping import map_log
from synchronisation.log_words import contents_lines
from synchronisation.motor_topic import motor_channel
from tests.synchronisation.test_any_log import NECK, truth
from xneck_foundation.errors import Refused
from xneck_foundation.input_file import check_input

LOG = Path("log.mcap")
WINCHES = ("winch1", "winch2", "winch3", "winch4")


def channel(of_efforts: bool, every: int = 1) -> JointStateChannel:
    """All motors, one of several messages, with the forces or without."""
    series = truth().part(slice(None, None, every))
    return JointStateChannel(WINCHES, series.time, series.matrix("theta"), series.matrix("f") if of_efforts else None)


def test_efforts_in_another_topic_are_said_to_be_there() -> None:
    contents = LogContents(topics={"joint_states": channel(False), "effort_commands": channel(True, every=2)})
    mapping = map_log(LOG, contents, NECK.M)
    assert (mapping.topic, mapping.forces) == ("joint_states", ())
    (said,) = [doubt for doubt in mapping.doubts if "forces" in doubt]
    assert "/joint_states holds none, but /effort_commands holds efforts; one topic must hold both" in said
    alone = map_log(LOG, LogContents(topics={"joint_states": channel(False)}), NECK.M)
    assert any(d.startswith("forces: no column is called one") for d in alone.doubts)


@pytest.mark.parametrize("joint", ["winch{}", "/joint_states/winch{}"])
def test_a_topic_that_cannot_be_read_is_refused_only_where_it_is_needed(joint: str) -> None:
    motors = tuple(m.model_copy(update={"joint": joint.format(j)}) for j, m in enumerate(NECK.motors, start=1))
    neck, readable = NECK.model_copy(update={"motors": motors}), channel(True)
    command = {"joint_command": "message 1: holds no positions, only effort"}
    found = motor_channel({"joint_states": readable}, neck, LOG, command)
    np.testing.assert_array_equal(found.matrix("theta"), readable.position)
    states = {"joint_states": "the joints' names change on the way"}
    with pytest.raises(Refused, match=r"joint_states.*cannot be read.*names change on the way"):
        motor_channel({"gripper": JointStateChannel(("g",), np.arange(2.0), np.ones((2, 1)), None)}, neck, LOG, states)


@pytest.mark.parametrize(
    ("names", "order"),
    [
        (("m3", "m1", "m2", "m4"), (1, 2, 0, 3)),
        (("axis_0_pos", "axis_3_pos", "axis_2_pos", "axis_1_pos"), (0, 3, 2, 1)),
        (("m3", "m1", "m2", "n4"), (0, 1, 2, 3)),
        (("m7", "m1", "m2", "m4"), (0, 1, 2, 3)),
        (("left", "up", "right", "down"), (0, 1, 2, 3)),
    ],
)
def test_joints_that_differ_by_a_number_stand_by_it(names: tuple[str, ...], order: tuple[int, ...]) -> None:
    """As the manual says, and as a mapping of the same log has them; other names tell no order."""
    log = channel(True)
    found = motor_channel({"states": JointStateChannel(names, log.time, log.position, log.effort)}, NECK, LOG)
    np.testing.assert_array_equal(found.matrix("theta"), log.position[:, order])
    assert log.effort is not None
    np.testing.assert_array_equal(found.matrix("f"), log.effort[:, order])


def test_efforts_in_a_topic_without_positions_are_said_to_be_there() -> None:
    contents = LogContents(
        topics={"joint_states": channel(False)}, faults={"cmd": "message 1: holds no positions, only effort"}
    )
    assert any(
        "/cmd cannot be read: message 1: holds no positions, only effort" in d for d in map_log(LOG, contents, 4).doubts
    )
    assert "log.mcap: topic /cmd: cannot be read (message 1" in "\n".join(contents_lines(LOG, contents))


def test_stamps_that_were_never_set_are_said_to_be_that() -> None:
    unset = JointStateChannel(WINCHES, np.zeros(1500), channel(True).position, channel(True).effort)
    for read in (
        lambda: map_log(LOG, LogContents(topics={"joint_states": unset}), NECK.M),
        lambda: motor_channel({"joint_states": unset}, NECK, LOG),
    ):
        with pytest.raises(Refused, match=r"header\.stamp is 0 s in every message of /joint_states: it was never set"):
            read()


def test_letters_in_joints_names_are_no_units_of_their_efforts() -> None:
    named = JointStateChannel(
        ("a_1", "a_2", "a_3", "a_4"), *[getattr(channel(True), of) for of in ("time", "position", "effort")]
    )
    mapping = map_log(LOG, LogContents(topics={"joint_states": named}), NECK.M)
    assert [force.unit for force in mapping.forces] == [None] * 4


@pytest.mark.parametrize("motors", [None, 4])
def test_joint_angles_and_data_sets_are_named_in_the_place_of_the_log(motors: int | None) -> None:
    named = ("alpha1", "alpha2", "alpha3", "sigma1", "sigma2", "sigma3")
    angles = JointStateChannel(named, channel(False).time, np.ones((1500, 6)), None)
    with pytest.raises(Refused, match="has alpha1: it holds joint angles, not the motors' log"):
        map_log(LOG, LogContents(topics={"angles": angles}), motors)
    with pytest.raises(Refused, match="is a data set of `xneck sync`, not the motors' log"):
        map_log(LOG, LogContents(topics=dict.fromkeys(("log", "state", "fasquelle"), angles)), motors)
    # of an arm of two joints angles and sigmas are as many columns as motors
    of_two = JointStateChannel(named[:2] + named[3:5], angles.time, np.ones((1500, 4)), None)
    names = ("log", "state", "fasquelle")
    for first in (angles, of_two):
        channels: dict[str, JointStateChannel] = {name: first if name == "log" else angles for name in names}
        with pytest.raises(Refused, match="is a data set of `xneck sync`, not the motors' log"):
            motor_channel(channels, NECK, LOG)
    forces = JointStateChannel(named, angles.time, angles.position, np.ones((1500, 6)))
    assert map_log(LOG, LogContents(topics={"winches": forces}), motors).angles[0].name == "alpha1"


@pytest.mark.parametrize("name", ["log_0.mcap", "log_0.db3"])
def test_a_bags_folder_is_answered_with_the_file_in_it(name: str, tmp_path: Path) -> None:
    (tmp_path / name).touch()
    with pytest.raises(Refused, match="is a folder; name a file"):
        check_input(tmp_path)
    (tmp_path / "metadata.yaml").touch()
    with pytest.raises(Refused, match=rf"is a folder; name the file in it, .*{name}"):
        check_input(tmp_path)
