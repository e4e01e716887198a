"""Series survive their file, and other people's programs read it."""

from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer as RosWriter

from identification.dataset.series import Series
from identification.files import joint_state
from identification.files.mcap_records import MAX_HELD_MESSAGES
from xneck_foundation.errors import Refused

NAMES = ("a", "alpha1", "sigma_alpha12", "x")


def made(samples: int = 200) -> Series:
    rng = np.random.default_rng(0)
    columns = {name: rng.normal(size=samples) for name in NAMES}
    columns["a"][3] = np.nan
    return Series(1_700_000_000 + 0.002 * np.arange(samples, dtype=float), columns)


@pytest.mark.parametrize("samples", [200, 2 * MAX_HELD_MESSAGES + 5])
def test_round_trip_keeps_every_bit_of_values_and_nanoseconds_of_time(samples: int, tmp_path: Path) -> None:
    file, series = tmp_path / "s.mcap", made(samples)
    joint_state.write(file, {"state": series}, {"why": {"n": 1}}, {"neck.yaml": b"x: 1"})
    found = joint_state.read(file)
    back = joint_state.as_series(found.logs["state"])
    assert list(back.columns) == list(series.columns)
    for name in NAMES:
        np.testing.assert_array_equal(back.columns[name], series.columns[name])
    np.testing.assert_array_equal(joint_state.nanoseconds(back.time), joint_state.nanoseconds(series.time))
    assert found.metadata["why"] == {"n": 1}
    assert found.attached == {"neck.yaml": b"x: 1"}


def test_ros_reads_what_we_write(tmp_path: Path) -> None:
    """The decoder of the MCAP project's ROS 2 package, which knows nothing of our byte table."""
    file, series = tmp_path / "s.mcap", made()
    joint_state.write(file, {"state": series}, {})
    seen = list(read_ros2_messages(file))
    assert len(seen) == len(series)
    for k in (0, 3, 199):
        message = seen[k].ros_msg
        assert tuple(message.name) == NAMES
        np.testing.assert_array_equal(message.position, [series.columns[name][k] for name in NAMES])
        stamp = message.header.stamp
        assert stamp.sec * 10**9 + stamp.nanosec == joint_state.nanoseconds(series.time)[k] == seen[k].log_time_ns


def test_we_read_what_ros_writes_also_when_names_and_frames_have_odd_lengths(tmp_path: Path) -> None:
    file = tmp_path / "ros.mcap"
    rng = np.random.default_rng(1)
    position, effort = rng.normal(size=(2, 20, 3))
    with file.open("wb") as stream:
        writer = RosWriter(stream)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", joint_state.DEFINITION)
        for k in range(20):
            message = {
                "header": {"stamp": {"sec": k, "nanosec": 5}, "frame_id": "base_x"},
                "name": ["j", "joint_2", "m3"],
                "position": position[k].tolist(),
                "velocity": [],
                "effort": effort[k].tolist(),
            }
            writer.write_message("/joint_states", schema, message, k, k)
        writer.finish()
    log = joint_state.read(file).logs["joint_states"]
    assert log.names == ("j", "joint_2", "m3")
    np.testing.assert_array_equal(log.position, position)
    np.testing.assert_array_equal(log.effort, effort)
    np.testing.assert_allclose(log.time, np.arange(20) + 5e-9)


def test_json_joint_states_are_read(tmp_path: Path) -> None:
    file = tmp_path / "json.mcap"
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("sensor_msgs/JointState", "jsonschema", b"{}")
        channel = writer.register_channel("/joint_states", "json", schema)
        for k in range(3):
            text = f'{{"header":{{"stamp":{{"sec":{k},"nanosec":0}}}},"name":["m1"],"position":[{k}],"effort":[2.5]}}'
            writer.add_message(channel, k, text.encode(), k)
        writer.finish()
    log = joint_state.read(file).logs["joint_states"]
    assert log.effort is not None
    np.testing.assert_array_equal(log.position[:, 0], [0, 1, 2])
    np.testing.assert_array_equal(log.effort[:, 0], 2.5)


def test_files_of_another_kind_are_refused(tmp_path: Path) -> None:
    text = tmp_path / "a.mcap"
    text.write_text("time,alpha1\n")
    with pytest.raises(Refused, match="MCAP"):
        joint_state.read(text)
    with pytest.raises(Refused, match="does not exist"):
        joint_state.read(tmp_path / "absent.mcap")
