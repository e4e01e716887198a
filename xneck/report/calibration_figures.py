"""Figures of a calibration's own page: residuals, coverage, sigma of projection, sigma at the arm, next pictures."""

from collections.abc import Sequence

import numpy as np
from matplotlib.patches import Polygon, Rectangle
from scipy.spatial import ConvexHull

from calibration.calibration_quality import CalibrationQuality, corner_errors
from calibration.camera import Camera
from calibration.coverage import NextPicture
from calibration.estimation import Calibration
from calibration.projection_uncertainty import ProjectionSigma, picture_ninths
from vision.linkage.arm_sigma import BENDS_RAD, ArmSigma
from xneck.report import style
from xneck.report.camera_figures import equal_scales
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.number_text import number_text
from xneck.report.recorded_axes import RecordedAxes
from xneck.report.svg import svg_panel

SHADES = ("#F3F7FB", "#D6E4F0", "#A9C8E2", "#6FA3CD", "#3A78AE", "#174E80")
"""colours of sigma, from small to large"""
_MAX_ARROWS = 600
_PICTURE_HEIGHT = 2.9
"""in, of panels that show the camera's picture"""


def residual_figure(calibration: Calibration) -> FigureBlock:
    """Errors of corners as arrows over the picture, and their radial part against the distance from the axis."""
    camera = calibration.camera
    pixels, errors = corner_errors(calibration)
    longest = float(np.quantile(np.linalg.norm(errors, axis=1), 0.98))
    magnified = _rounded_down(0.04 * camera.width / max(longest, 1e-6))

    figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
    _draw_picture_frame(axes, camera, "errors of corners")
    step = -(-len(pixels) // _MAX_ARROWS)
    (x, y), (dx, dy) = pixels[::step].T, errors[::step].T
    gap = np.full(len(x), np.nan)
    xs, ys = (np.column_stack([at, at + magnified * error, gap]).ravel() for at, error in ((x, dx), (y, dy)))
    axes.plot(xs, ys, color=style.CABLES[0], linewidth=0.8)
    axes.record("its error", "arrows", x=x, y=y, dx=dx, dy=dy)
    style.dots(axes, "corner", x, y, style.MEASURED, 1.6)
    arrows = svg_panel(figure, "residuals", f"errors of the corners over the picture, {magnified:g} times enlarged")

    from_axis = pixels - camera.parameters[2:4]
    radius = np.linalg.norm(from_axis, axis=1)
    radial = np.sum(errors * from_axis, axis=1) / np.maximum(radius, 1e-9)
    figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
    reach = 1.1 * float(np.quantile(np.abs(radial), 0.995))
    style.dots(axes, "corner", radius, radial, style.CABLES[0], 2.0, 0.5, reach)
    order = np.argsort(radius)
    groups = [group for group in np.array_split(order, 12) if len(group)]
    middles = np.array([float(np.mean(radius[group])) for group in groups])
    means = np.array([float(np.mean(radial[group])) for group in groups])
    style.line(axes, "mean", middles, means, style.MEASURED, width=1.6)
    axes.set_ylim(-reach * 1.05, reach * 1.05)
    axes.set_title("away from the optical axis")
    axes.set_xlabel("distance from the axis, px")
    axes.set_ylabel("error outwards, px")
    along = svg_panel(figure, "radial", "errors away from the optical axis against the distance from it, px")
    return FigureBlock(
        "Seen less predicted",
        f"Each line leads from a corner in the direction of its error (seen less predicted), {magnified:g} times enlarged. They "
        "should point anywhere: neighbours that agree are a lens model that does not fit or a board that is not flat, and so "
        "is a mean that leaves zero in the second panel.",
        (arrows, along),
        (
            LegendEntry("corner", style.MEASURED, "dot"),
            LegendEntry("its error", style.CABLES[0]),
            LegendEntry("mean", style.MEASURED),
        ),
    )


def coverage_figure(calibration: Calibration, quality: CalibrationQuality) -> FigureBlock:
    """Outlines of the boards over the picture, and how steep and how far away they were."""
    figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
    _shade_missing(axes, calibration.camera, quality)
    _draw_picture_frame(axes, calibration.camera, f"{len(calibration.views)} boards in the picture")
    for k, view in enumerate(calibration.views):
        points = view.image_points
        outline = points[ConvexHull(points).vertices]
        colour = style.cable_colour(k)
        axes.add_patch(Polygon(outline, closed=True, fill=False, edgecolor=colour, linewidth=1.0))
        axes.record(view.name, "outline", x=outline[:, 0], y=outline[:, 1])
        style.dots(axes, view.name, points[:, 0], points[:, 1], colour, 1.7, 0.7)
    outlines = svg_panel(figure, "outlines", "outlines of the boards and their corners over the picture")
    figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
    coverage = quality.coverage
    for k, (tilt, distance) in enumerate(zip(np.degrees(coverage.tilts), coverage.distances, strict=True)):
        axes.plot([distance], [tilt], marker="o", markersize=5, color=style.cable_colour(k), linestyle="none")
        axes.record(calibration.views[k].name, "dots", x=[distance], y=[tilt])
    axes.set_ylim(0, max(45.0, 1.1 * float(np.degrees(coverage.tilts.max()))))
    axes.set_xlim(0, 1.12 * float(coverage.distances.max()))
    style.span(axes, "tilts that tell most", 20, 40, style.UNDERLAY, 0.3, flat=True)
    axes.set_title("how the boards stood")
    axes.set_xlabel("distance of the board's middle, m")
    axes.set_ylabel("tilt against the picture, deg")
    poses = svg_panel(figure, "stood", "tilt of each board against its distance")
    legend = [LegendEntry("tilts of 20 to 40 degrees tell most", style.UNDERLAY, "band")]
    if coverage.missing:
        legend.append(LegendEntry("no corner in this ninth", style.GAP, "band"))
    return FigureBlock(
        "Where the boards were",
        f"A colour a picture. Corners lie in {100 * coverage.share:.0f} % of the picture's cells; the lens is known only where "
        "they are, and the focal length only from boards that were tilted.",
        (outlines, poses),
        tuple(legend),
    )


def sigma_figure(calibration: Calibration, quality: CalibrationQuality, arm: ArmSigma | None) -> FigureBlock:
    """Sigma of projection over the picture, and at the arm's markers."""
    camera, projection = calibration.camera, quality.projection
    levels = _shade_levels(projection.worst)
    figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
    _shade_sigma(axes, projection, levels)
    _shade_missing(axes, camera, quality)
    _draw_picture_frame(axes, camera, "over the picture")
    panels = [svg_panel(figure, "sigma", "sigma of projection over the picture, px")]
    caption = (
        "How far a direction would be seen from where the camera model puts it (1 σ, px), when the camera's orientation is "
        f"fitted anew: median {number_text(projection.median, 2)} px, {number_text(projection.worst, 2)} px at worst, in the "
        f"{projection.worst_place}. It takes the lens model for true, also where no corner was."
    )
    legend = [
        LegendEntry(f"{low:g} to {high:g} px", shade, "broad")
        for low, high, shade in zip(levels[:-1], levels[1:], SHADES, strict=False)
    ]
    if arm is not None:
        figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
        magnified = _rounded_down(0.03 * camera.width / max(float(arm.sigma_px.max()), 1e-9))
        _draw_picture_frame(axes, camera, f"at the arm, {number_text(arm.distance, 2)} m away")
        turn = np.linspace(0, 2 * np.pi, 17)
        for k, (points, sigma) in enumerate(zip(arm.pixels, arm.sigma_px, strict=True)):
            colour = style.joint_colour(k)
            bend = f"all joints at {number_text(float(np.degrees(BENDS_RAD[k])), 2)} deg"
            style.dots(axes, bend, points[:, 0], points[:, 1], colour, 1.8)
            axes.record(bend, "circles", x=points[:, 0], y=points[:, 1], radius=sigma)
            x, y = (
                np.column_stack([points[:, k, None] + magnified * sigma[:, None] * part, np.full(len(points), np.nan)])
                for k, part in enumerate((np.cos(turn), np.sin(turn)))
            )
            axes.plot(x.ravel(), y.ravel(), color=colour, linewidth=0.7)
        panels.append(svg_panel(figure, "arm", "sigma of the camera at the markers of the arm in three poses"))
        caption += (
            f" The second panel shows it at the corners of the arm's markers, its pose fitted too: circles of 1 σ, {magnified:g} "
            "times enlarged."
        )
        legend += [
            LegendEntry(f"all joints at {number_text(float(np.degrees(bend)), 2)} deg", style.joint_colour(k), "dot")
            for k, bend in enumerate(BENDS_RAD)
        ]
    return FigureBlock("Sigma of projection", caption, tuple(panels), tuple(legend))


def next_board_figure(camera: Camera, quality: CalibrationQuality) -> FigureBlock:
    """Where to hold the board next, a panel a picture."""
    panels = []
    for k, picture in enumerate(quality.next_pictures):
        figure, axes = style.one_row_panel(_PICTURE_HEIGHT)
        _shade_missing(axes, camera, quality)
        _draw_picture_frame(axes, camera, f"picture {k + 1}: {picture.where}")
        _draw_board(axes, picture, style.cable_colour(k))
        panels.append(svg_panel(figure, f"next{k}", f"where to hold the board: {picture.words}"))
    return FigureBlock(
        "Where to hold the board",
        "Each outline is the board as it would be seen, its narrower side away from the camera. The first helps most; each "
        "further one counts on those before it.",
        tuple(panels),
    )


def _draw_board(axes: RecordedAxes, picture: NextPicture, colour: str) -> None:
    corners = picture.outline
    axes.add_patch(Polygon(corners, closed=True, facecolor=colour, alpha=0.18, edgecolor="none"))
    axes.record("board", "outline", x=corners[:, 0], y=corners[:, 1])
    lines: list[tuple[Sequence[float], Sequence[float]]] = []
    for share in np.linspace(0, 1, 7).tolist():
        top, bottom = ((1 - share) * corners[a] + share * corners[b] for a, b in ((0, 1), (3, 2)))
        left, right = ((1 - share) * corners[a] + share * corners[b] for a, b in ((0, 3), (1, 2)))
        lines += [((top[0], bottom[0]), (top[1], bottom[1])), ((left[0], right[0]), (left[1], right[1]))]
    for x, y in lines:
        axes.plot(x, y, color=colour, linewidth=0.8)


def _shade_sigma(axes: RecordedAxes, projection: ProjectionSigma, levels: np.ndarray) -> None:
    values = np.ma.masked_invalid(projection.sigma)
    axes.record("sigma, px", "shades", x=projection.u, y=projection.v, sigma=values.filled(np.nan))
    axes.contourf(projection.u, projection.v, values, levels=levels, colors=SHADES[: len(levels) - 1], extend="max")


def _shade_missing(axes: RecordedAxes, camera: Camera, quality: CalibrationQuality) -> None:
    for name, rows, columns in picture_ninths(camera.width, camera.height):
        if name in quality.coverage.missing:
            size = (columns.stop - columns.start, rows.stop - rows.start)
            axes.add_patch(Rectangle((columns.start, rows.start), *size, color=style.GAP, alpha=0.45, linewidth=0))
            left, top, right, bottom = columns.start, rows.start, columns.stop, rows.stop
            axes.record(
                f"no corner in the {name}", "outline", x=[left, right, right, left], y=[top, top, bottom, bottom]
            )


def _draw_picture_frame(axes: RecordedAxes, camera: Camera, title: str) -> None:
    """Axes in px to the right and down, with the frame of the camera's picture."""
    axes.add_patch(Rectangle((-0.5, -0.5), camera.width, camera.height, fill=False, edgecolor=style.MUTED))
    equal_scales(axes, camera.width / 2, camera.height / 2, 0.52 * camera.width, 0.52 * camera.height)
    axes.invert_yaxis()
    axes.set_title(title)
    axes.set_xlabel("px to the right")
    axes.set_ylabel("px down")


def _shade_levels(worst: float) -> np.ndarray:
    """Bounds of the shades, px: 0, then steps of 1, 2, 5 up to the first that `worst` does not exceed."""
    steps = [step * 10.0**power for power in range(-9, 9) for step in (1, 2, 5)]
    top = next(k for k, step in enumerate(steps) if step >= worst)
    return np.array([0.0, *steps[top - len(SHADES) + 1 : top + 1]])


def _rounded_down(value: float) -> float:
    """`value` rounded down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1, 2, 5) if step * power <= value) * power)
