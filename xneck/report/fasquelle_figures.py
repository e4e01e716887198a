"""Fasquelle's figures 6, 7 and 8, drawn from this recording."""

import numpy as np

from identification.fasquelle.reconstruction import Reconstruction
from mechanism.elasticity import ELASTIC_MODELS, ElasticModel
from xneck.report import style
from xneck.report.figure_block import FigureBlock, LegendEntry, LegendMark
from xneck.report.number_text import number_text
from xneck.report.svg import svg_panel

_STYLES: dict[ElasticModel, LegendMark] = {1: "solid", 2: "dashed", 3: "dotted"}
_TENSION_BINS = 8


def couples(reconstruction: Reconstruction) -> FigureBlock:
    """Figure 6, couples: one panel a joint."""
    panels = []
    for i in range(reconstruction.couple_measured.shape[1]):
        figure, axes = style.one_row_panel(2.7)
        style.line(
            axes,
            "measured",
            reconstruction.time,
            reconstruction.couple_measured[:, i],
            style.UNDERLAY,
            width=style.UNDERLAY_WIDTH,
        )
        style.line(
            axes,
            "without friction",
            reconstruction.time,
            reconstruction.couple_without_friction[:, i],
            style.FRICTION["none"],
        )
        style.line(axes, "dry friction", reconstruction.time, reconstruction.couple_dry[:, i], style.FRICTION["dry"])
        style.line(
            axes,
            "dry and viscous friction",
            reconstruction.time,
            reconstruction.couple_dry_and_viscous[:, i],
            style.FRICTION["viscous"],
            "dashed",
        )
        axes.set_title(f"joint {i + 1}", color=style.joint_colour(i))
        axes.set_xlabel(style.LOG_TIME)
        axes.set_ylabel("couple (Z f), N m")
        panels.append(svg_panel(figure, f"couple{i}", f"couple on joint {i + 1}, measured and modelled"))
    return FigureBlock(
        "Couples Z f: Fasquelle's figure 6",
        "The arm's equation with friction should lie on the measured couple and without it should not; where viscous "
        "friction (dashed) changes nothing, it is not needed.",
        tuple(panels),
        (
            LegendEntry("measured", style.UNDERLAY, "broad"),
            LegendEntry("without friction", style.FRICTION["none"]),
            LegendEntry("dry friction", style.FRICTION["dry"]),
            LegendEntry("dry and viscous friction", style.FRICTION["viscous"], "dashed"),
        ),
    )


def couple_errors(reconstruction: Reconstruction) -> list[tuple[str, list[float]]]:
    """Name of each model, and its RMS error of the couple on each joint, N m."""
    modelled = (
        ("without friction", reconstruction.couple_without_friction),
        ("dry friction", reconstruction.couple_dry),
        ("dry and viscous friction", reconstruction.couple_dry_and_viscous),
    )
    return [
        (name, np.sqrt(np.mean((couple - reconstruction.couple_measured) ** 2, axis=0)).tolist())
        for name, couple in modelled
    ]


def tensions(reconstruction: Reconstruction) -> FigureBlock:
    """Figure 7, tensions: one panel a cable."""
    panels = []
    for j in range(reconstruction.tension_from_force.shape[1]):
        figure, axes = style.one_row_panel(2.7)
        style.line(
            axes,
            "from forces",
            reconstruction.time,
            reconstruction.tension_from_force[:, j],
            style.UNDERLAY,
            width=style.UNDERLAY_WIDTH,
        )
        for model in ELASTIC_MODELS:
            name, elastic = f"elastic model {model}", reconstruction.tension_elastic[model][:, j]
            style.line(axes, name, reconstruction.time, elastic, style.MODELS[model], _STYLES[model])
        axes.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        axes.set_xlabel(style.LOG_TIME)
        axes.set_ylabel("tension, N")
        panels.append(svg_panel(figure, f"tension{j}", f"tension of cable {j + 1} by forces and by elastic models"))
    return FigureBlock(
        "Tension in the cables: Fasquelle's figure 7",
        "Tension from the motor forces less friction, beside what the elongation gives through the three elastic "
        "models; where they part, the cable is not that spring.",
        tuple(panels),
        (
            LegendEntry("from forces", style.UNDERLAY, "broad"),
            *(LegendEntry(f"elastic model {m}", style.MODELS[m], _STYLES[m]) for m in ELASTIC_MODELS),
        ),
    )


def tension_errors(reconstruction: Reconstruction) -> FigureBlock:
    """Figure 8, errors of tension: one panel a cable, a colour for each model, lines for the mean in bins of equal count."""
    panels = []
    for j in range(reconstruction.tension_from_force.shape[1]):
        figure, axes = style.one_row_panel(2.7)
        force = reconstruction.tension_from_force[:, j]
        edges = np.quantile(force, np.linspace(0, 1, _TENSION_BINS + 1))
        bins = np.clip(np.searchsorted(edges, force, side="right") - 1, 0, _TENSION_BINS - 1)
        axes.axhline(0, color=style.MUTED, linewidth=0.7)
        for model in ELASTIC_MODELS:
            error = reconstruction.tension_error(model)[:, j]
            style.dots(axes, f"elastic model {model}", force, error, style.MODELS[model], size=1.6, opacity=0.35)
            filled = [k for k in range(_TENSION_BINS) if np.any(bins == k)]
            at = np.array([force[bins == k].mean() for k in filled])
            mean = np.array([error[bins == k].mean() for k in filled])
            style.line(axes, f"mean of elastic model {model}", at, mean, style.MODELS[model], _STYLES[model], width=1.8)
        axes.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        axes.set_xlabel("tension from forces, N")
        axes.set_ylabel("error of the model, N")
        panels.append(svg_panel(figure, f"error{j}", f"error of the elastic models for cable {j + 1} against tension"))
    low, high = _error_by_tension(reconstruction)
    return FigureBlock(
        "Error against tension: Fasquelle's figure 8",
        "Elastic model less tension from forces, with the mean in eight bins as lines: an error that grows with tension asks "
        f"for a cable that is not linear (model 1: {number_text(low, 2)} N on average in the quarter of lowest tension, "
        f"{number_text(high, 2)} N in that of highest).",
        tuple(panels),
        tuple(LegendEntry(f"elastic model {m}", style.MODELS[m], _STYLES[m]) for m in ELASTIC_MODELS),
    )


def _error_by_tension(reconstruction: Reconstruction) -> tuple[float, float]:
    """Mean size of model 1's error in the quarters of lowest and of highest tension of each cable, N."""
    force, error = reconstruction.tension_from_force, np.abs(reconstruction.tension_error(1))
    low, high = np.quantile(force, [0.25, 0.75], axis=0)
    return float(error[force <= low].mean()), float(error[force >= high].mean())
