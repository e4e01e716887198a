"""Layouts name curves that are in the data set, and all of them lie on one time axis."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from mcap_ros2.reader import read_ros2_messages

from identification.dataset.clock_record import log_time
from identification.dataset.dataset import DataSet
from identification.dataset.dataset_file import dataset_series, write_dataset
from tests.xneck.viewers.recording_result import dataset
from xneck.viewers.foxglove import foxglove_layout
from xneck.viewers.plotjuggler import plotjuggler_layout

EPOCH = 1.7e9
"""a log's clock that counts from 1970, beside a camera's that counts from its switching on"""
DECODERS = Path(__file__).with_name("foxglove_decoders.cjs")
WANTED = {f"{stem}{k}" for stem, count in (("alpha", 3), ("sigma_alpha", 3), ("theta", 4), ("x", 4), ("f", 4))
          for k in range(1, count + 1)}  # fmt: skip


@pytest.fixture(scope="module")
def data() -> DataSet:
    return dataset(EPOCH)


@pytest.fixture(scope="module")
def file(data: DataSet, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("viewers") / "dataset.mcap"
    write_dataset(data, path)
    return path


@pytest.fixture(scope="module")
def messages(file: Path) -> dict[str, list[Any]]:
    """By topic, as the ROS 2 package of the MCAP project reads them."""
    found: dict[str, list[Any]] = {}
    for message in read_ros2_messages(file):
        found.setdefault(message.channel.topic, []).append(message)
    return found


def paths_of(layout: str) -> list[dict[str, Any]]:
    return [path for plot in json.loads(layout)["configById"].values() for path in plot["paths"]]


def test_all_messages_are_logged_by_the_logs_clock_and_keep_their_own_stamps(
    data: DataSet, messages: dict[str, list[Any]]
) -> None:
    """Also the camera's, 54 years from it by its own clock: a viewer would show a single point otherwise."""
    logged = np.array([m.log_time_ns for m in messages["/angles"]]) / 1e9
    np.testing.assert_allclose(logged, log_time(data.clock, data.angles.time), atol=1e-6)
    stamps = [m.ros_msg.header.stamp for m in messages["/angles"]]
    np.testing.assert_allclose([s.sec + s.nanosec / 1e9 for s in stamps], data.angles.time, atol=1e-9)
    every = [m.log_time_ns / 1e9 for topic in messages.values() for m in topic]
    assert min(every) > EPOCH - 1
    assert max(every) < EPOCH + 4


def test_foxglove_paths_lead_to_the_columns_that_they_are_labelled_with(
    data: DataSet, messages: dict[str, list[Any]]
) -> None:
    shown = set()
    for path in paths_of(foxglove_layout(dataset_series(data))):
        match = re.fullmatch(r"(/\w+)\.position\[(\d+)\]", path["value"])
        assert match is not None
        topic, place = match[1], int(match[2])
        for message in (messages[topic][0], messages[topic][-1]):
            assert path["label"] == f"{topic[1:]} {message.ros_msg.name[place]}"
        if topic == "/state":
            shown.add(messages[topic][0].ros_msg.name[place])
    assert shown == WANTED


def test_foxgloves_tree_holds_every_plot_once(data: DataSet) -> None:
    def leaves(tree: Any) -> list[str]:
        return [tree] if isinstance(tree, str) else leaves(tree["first"]) + leaves(tree["second"])

    layout = json.loads(foxglove_layout(dataset_series(data)))
    assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])


def test_plotjuggler_curves_are_those_it_makes_of_the_file(
    data: DataSet, file: Path, messages: dict[str, list[Any]]
) -> None:
    """It calls a joint's position `/topic/joint/position`."""
    root = ET.fromstring(plotjuggler_layout(dataset_series(data), file.name))
    made = {f"{topic}/{name}/position" for topic, found in messages.items() for name in found[0].ros_msg.name}
    curves = [curve.attrib["name"] for curve in root.iter("curve")]
    assert set(curves) <= made
    assert {name.split("/")[2] for name in curves if name.startswith("/state/")} == WANTED
    (parameters,) = root.iter("parameters")
    assert set(parameters.attrib["selected_topics"].split(";")) == set(messages)
    for splitter in root.iter("DockSplitter"):
        assert len(splitter) == int(splitter.attrib["count"]) == len(splitter.attrib["sizes"].split(";"))


def test_without_forces_nothing_is_shown_of_them() -> None:
    series = dataset_series(dataset(3.0, forces=False))
    assert not any(" f1" in path["label"] for path in paths_of(foxglove_layout(series)))
    assert "/state/f1/" not in plotjuggler_layout(series, "dataset.mcap")


def test_foxgloves_own_decoders_give_the_same_curves(data: DataSet, file: Path, tmp_path: Path) -> None:
    """NODE_PATH=folder with @mcap/core, @mcap/nodejs, @mcap/support, @foxglove/rosmsg and @foxglove/rosmsg2-serialization."""
    node = shutil.which("node")
    if node is None or "NODE_PATH" not in os.environ:
        pytest.skip("needs node, and Foxglove's packages from npm under NODE_PATH")
    layout = tmp_path / "foxglove.json"
    layout.write_text(foxglove_layout(dataset_series(data)))
    done = subprocess.run([node, DECODERS, file, layout], capture_output=True, text=True, check=True)
    curves = json.loads(done.stdout)
    series = dataset_series(data)
    assert set(curves) == {path["label"] for path in paths_of(layout.read_text())}
    for label, (times, values) in curves.items():
        topic, column = label.split()
        expected = [None if v != v else v for v in series[topic].columns[column].tolist()]
        assert values == expected
        assert EPOCH - 1 < times[0] < times[-1] < EPOCH + 4
