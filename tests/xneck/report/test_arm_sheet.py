"""The sheet of any arm holds all of it, where it is, and its numbers as they are."""

import itertools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mechanism.arm import arm_of
from mechanism.cable_path import bar_ends
from mechanism.description import Neck, Spring, read_neck
from mechanism.geometry import poses
from mechanism.neck_template import neck_template
from mechanism.printed_markers import BarMarker
from tests.paths import NECK_FILE
from xneck.report.arm_sheet import arm_sheet
from xneck.report.recorded_axes import axes_records
from xneck.report.style import drawing
from xneck_foundation.strict_yaml import parse_yaml, validate_document


def described(mechanisms: int, cables: int) -> Neck:
    return validate_document(parse_yaml(neck_template(mechanisms, cables), "neck.yaml"), Neck, "neck.yaml")


def sheet(neck: Neck, *degrees: float) -> Figure:
    alpha = np.radians(degrees) if degrees else np.zeros(neck.N)
    with drawing():
        figure = arm_sheet(neck, alpha, "neck.yaml")
        FigureCanvasAgg(figure).draw()
    return figure


def marks(figure: Figure) -> dict[str, np.ndarray]:
    (axes,) = axes_records(figure)
    return {mark.name: np.column_stack([mark.columns["x"], mark.columns["y"]]) / 1e3 for mark in axes.marks}


def words(figure: Figure) -> str:
    return "\n".join(text.get_text() for text in figure.texts)


@pytest.mark.parametrize(("mechanisms", "cables"), list(itertools.product([1, 2, 6], [1, 4, 8])))
def test_every_part_is_on_it_within_its_edges(mechanisms: int, cables: int) -> None:
    figure = sheet(described(mechanisms, cables), *np.linspace(-25, 30, mechanisms))
    drawn = marks(figure)
    wanted = {f"bar {i}" for i in range(mechanisms + 1)} | {f"cable {j + 1}" for j in range(cables)}
    wanted |= {f"marker {i}" for i in range(mechanisms + 1)} | {f"drum {j + 1}" for j in range(cables)}
    wanted |= {f"spring {i + 1} {side}" for i in range(mechanisms) for side in ("left", "right")}
    assert wanted <= set(drawn)
    (axes,) = figure.axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for name, points in drawn.items():
        x, y = 1e3 * points.T
        assert left <= x.min() <= x.max() <= right, name
        assert low <= y.min() <= y.max() <= high, name
    page = figure.bbox
    for text in figure.texts:
        box = text.get_window_extent()
        assert page.x0 <= box.x0 <= box.x1 <= page.x1, text.get_text()
        assert page.y0 <= box.y0 <= box.y1 <= page.y1, text.get_text()


def test_bars_and_markers_are_where_the_pose_has_them() -> None:
    neck = read_neck(NECK_FILE)
    assert neck.markers is not None
    further = BarMarker(id=9, diagonal="B2", at=(0.02, 0.01), angle=0.4)
    placed = neck.markers.model_copy(update={"on_bars": (*neck.markers.on_bars, further)})
    neck = neck.model_copy(update={"markers": placed})
    alpha = np.radians([20.0, -30.0, 10.0])
    drawn = marks(sheet(neck, 20.0, -30.0, 10.0))
    pose = poses(arm_of(neck), alpha)
    ends = bar_ends(arm_of(neck), pose)
    for i in range(4):
        np.testing.assert_allclose(drawn[f"bar {i}"] @ [1, 1j], ends[i], atol=1e-12)
        np.testing.assert_allclose((drawn[f"marker {i}"] @ [1, 1j]).mean(), pose.bar_middle[i], atol=1e-12)
    # B2: index 1 of the second mechanism's diagonals, from bottom right to top left
    along = np.exp(1j * pose.diagonal_angle[1, 1])
    corners = drawn["marker 9"] @ [1, 1j]
    np.testing.assert_allclose(corners.mean(), pose.diagonal_middle[1, 1] + (0.02 + 0.01j) * along, atol=1e-12)
    np.testing.assert_allclose(np.abs(np.diff(corners)), placed.size, rtol=1e-12)
    np.testing.assert_allclose(np.angle((corners[1] - corners[0]) / along), 0.4, atol=1e-12)


def test_the_legend_has_the_numbers() -> None:
    neck = read_neck(NECK_FILE)
    one = neck.mechanisms[1]
    springs = one.springs.model_copy(update={"right": Spring(stiffness=350.0, free_length=0.045), "slack": True})
    other = one.model_copy(update={"springs": springs, "L": 0.1234})
    neck = neck.model_copy(update={"mechanisms": (neck.mechanisms[0], other, neck.mechanisms[2]), "markers": None})
    neck = neck.model_copy(update={"alpha_zero": (0.01, 0.0, -0.02)})
    said = words(sheet(neck))
    for line in (
        "1: L 100 mm, b 50 mm, pulleys r 5 mm",
        "2: L 123.4 mm, b 50 mm, pulleys r 5 mm",
        "top bar 50 g, 10 kg mm²; diagonals 30 g, 25 kg mm² each",
        "spring left 400 N/m, free 50 mm, right 350 N/m, free 45 mm; hang loose",
        "1-4: gear R 25, drum rd 10 mm, Ia 5 kg mm², 2048 counts a turn",
        "3: 2 x strut, right; 1.3 m, 0.79 mm², x0 4 mm",
        "gravity 9.81 m/s² down",
        "none: joint angles come from elsewhere",
        "angles read 0.573, 0, -1.15 deg while the arm stands straight",
    ):
        assert line in said, line


def test_hundreds_of_parts_are_counted() -> None:
    said = words(sheet(described(30, 60)))
    assert "... and 36 more" in said
    assert "... and 7 more" in said
