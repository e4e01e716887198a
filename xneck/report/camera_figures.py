"""How a camera was calibrated: where the corners lay in the picture, and how far they are from where the model puts them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from calibration.calibration_quality import corner_errors
from calibration.estimation import Calibration
from xneck.report import style
from xneck.report.figure_block import FigureBlock
from xneck.report.svg import svg_panel


def coverage_and_errors(calibration: Calibration) -> FigureBlock:
    """The figure of a calibration in a recording's page: corners over the picture, and their errors."""
    camera = calibration.camera
    pixels, errors = corner_errors(calibration)

    figure, axes = style.one_row_panel(2.9)
    for k, view in enumerate(calibration.views):
        x, y = view.image_points.T
        style.dots(axes, view.name, x, y, style.cable_colour(k), 2.4, 0.8)
    axes.add_patch(Rectangle((0, 0), camera.width, camera.height, fill=False, edgecolor=style.MUTED))
    equal_scales(axes, camera.width / 2, camera.height / 2, 0.52 * camera.width, 0.52 * camera.height)
    axes.invert_yaxis()
    axes.set_title(f"{len(pixels)} corners in the picture")
    axes.set_xlabel("px to the right")
    axes.set_ylabel("px down")
    coverage = svg_panel(figure, "coverage", "corners of all pictures over the camera's picture")

    figure, axes = style.one_row_panel(2.9)
    reach = 1.05 * float(np.quantile(np.abs(errors), 0.998))
    style.dots(axes, "corners", errors[:, 0], errors[:, 1], style.CABLES[0], 2.0, 0.5)
    turn = np.linspace(0, 2 * np.pi, 90)
    circle = calibration.rms_px * np.cos(turn), calibration.rms_px * np.sin(turn)
    style.line(axes, "RMS", *circle, style.MEASURED, width=1.4)
    equal_scales(axes, 0.0, 0.0, reach, reach)
    axes.set_title("what the camera model leaves")
    axes.set_xlabel("error to the right, px")
    axes.set_ylabel("error down, px")
    error_panel = svg_panel(figure, "corner-errors", "errors of the corners, px")
    return FigureBlock(
        "Coverage and errors",
        "The corners should reach into all parts of the picture (a colour a picture), and their errors should be a round "
        f"cloud without a tail, of the size of the circle (RMS {calibration.rms_px:.3f} px).",
        (coverage, error_panel),
    )


def equal_scales(axes: Axes, x: float, y: float, half_width: float, half_height: float) -> None:
    """Sets limits around (x, y) that hold the rectangle with one scale in both directions; the axes keep their size."""
    box = axes.get_window_extent()
    scale = max(half_width / box.width, half_height / box.height)
    axes.set_xlim(x - scale * box.width, x + scale * box.width)
    axes.set_ylim(y - scale * box.height, y + scale * box.height)
