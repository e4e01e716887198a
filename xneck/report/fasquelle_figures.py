"""Fasquelle's figures 6, 7 and 8, drawn from this recording."""

import numpy as np

from identification.fasquelle.reconstruction import Reconstruction
from mechanism.elasticity import MODELS, Model
from xneck.report import style
from xneck.report.block import Block, Entry, Mark
from xneck.report.svg import inline
from xneck.report.wording import number

_STYLES: dict[Model, Mark] = {1: "solid", 2: "dashed", 3: "dotted"}
_BINS = 8


def couples(found: Reconstruction) -> Block:
    """Figure 6: one panel a joint."""
    panels = []
    for i in range(found.couple_measured.shape[1]):
        figure, axes = style.panel(2.7)
        style.line(axes, "measured", found.time, found.couple_measured[:, i], style.BROAD, width=style.BROAD_WIDTH)
        style.line(axes, "without friction", found.time, found.couple_without_friction[:, i], style.FRICTION["none"])
        style.line(axes, "dry friction", found.time, found.couple_dry[:, i], style.FRICTION["dry"])
        style.line(
            axes,
            "dry and viscous friction",
            found.time,
            found.couple_dry_and_viscous[:, i],
            style.FRICTION["viscous"],
            "dashed",
        )
        axes.set_title(f"joint {i + 1}", color=style.joint_colour(i))
        axes.set_xlabel("time on the log's clock, s")
        axes.set_ylabel("couple (Z f), N m")
        panels.append(inline(figure, f"couple{i}", f"couple on joint {i + 1}, measured and modelled"))
    return Block(
        "Couples Z f: Fasquelle's figure 6",
        "The arm's equation with friction should lie on the measured couple and without it should not; where viscous "
        "friction (dashed) changes nothing, it is not needed.",
        tuple(panels),
        (
            Entry("measured", style.BROAD, "broad"),
            Entry("without friction", style.FRICTION["none"]),
            Entry("dry friction", style.FRICTION["dry"]),
            Entry("dry and viscous friction", style.FRICTION["viscous"], "dashed"),
        ),
    )


def couple_errors(found: Reconstruction) -> list[tuple[str, list[float]]]:
    """RMS of each model less the measured couple, N m, of every joint."""
    modelled = (
        ("without friction", found.couple_without_friction),
        ("dry friction", found.couple_dry),
        ("dry and viscous friction", found.couple_dry_and_viscous),
    )
    return [
        (name, np.sqrt(np.mean((couple - found.couple_measured) ** 2, axis=0)).tolist()) for name, couple in modelled
    ]


def tensions(found: Reconstruction) -> Block:
    """Figure 7: one panel a cable."""
    panels = []
    for j in range(found.tension_from_force.shape[1]):
        figure, axes = style.panel(2.7)
        style.line(
            axes, "from forces", found.time, found.tension_from_force[:, j], style.BROAD, width=style.BROAD_WIDTH
        )
        for model in MODELS:
            name, elastic = f"elastic model {model}", found.tension_elastic[model][:, j]
            style.line(axes, name, found.time, elastic, style.MODELS[model], _STYLES[model])
        axes.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        axes.set_xlabel("time on the log's clock, s")
        axes.set_ylabel("tension, N")
        panels.append(inline(figure, f"tension{j}", f"tension of cable {j + 1} by forces and by elastic models"))
    return Block(
        "Tension in the cables: Fasquelle's figure 7",
        "Tension from the motor forces less friction, beside what the elongation gives through the three elastic "
        "models; where they part, the cable is not that spring.",
        tuple(panels),
        (
            Entry("from forces", style.BROAD, "broad"),
            *(Entry(f"elastic model {m}", style.MODELS[m], _STYLES[m]) for m in MODELS),
        ),
    )


def tension_errors(found: Reconstruction) -> Block:
    """Figure 8: one panel a cable, the models apart by colour, their mean error in bins of equal count as lines."""
    panels = []
    for j in range(found.tension_from_force.shape[1]):
        figure, axes = style.panel(2.7)
        force = found.tension_from_force[:, j]
        edges = np.quantile(force, np.linspace(0, 1, _BINS + 1))
        bins = np.clip(np.searchsorted(edges, force, side="right") - 1, 0, _BINS - 1)
        axes.axhline(0, color=style.QUIET, linewidth=0.7)
        for model in MODELS:
            error = found.tension_error(model)[:, j]
            style.dots(axes, f"elastic model {model}", force, error, style.MODELS[model], size=1.6, opacity=0.35)
            filled = [k for k in range(_BINS) if np.any(bins == k)]
            at = np.array([force[bins == k].mean() for k in filled])
            mean = np.array([error[bins == k].mean() for k in filled])
            style.line(axes, f"mean of elastic model {model}", at, mean, style.MODELS[model], _STYLES[model], width=1.8)
        axes.set_title(f"cable {j + 1}", color=style.cable_colour(j))
        axes.set_xlabel("tension from forces, N")
        axes.set_ylabel("error of the model, N")
        panels.append(inline(figure, f"error{j}", f"error of the elastic models for cable {j + 1} against tension"))
    low, high = _error_by_tension(found)
    return Block(
        "Error against tension: Fasquelle's figure 8",
        "Elastic model less tension from forces, with the mean in eight bins as lines: an error that grows with tension asks "
        f"for a cable that is not linear (model 1: {number(low, 2)} N on average in the quarter of lowest tension, "
        f"{number(high, 2)} N in that of highest).",
        tuple(panels),
        tuple(Entry(f"elastic model {m}", style.MODELS[m], _STYLES[m]) for m in MODELS),
    )


def _error_by_tension(found: Reconstruction) -> tuple[float, float]:
    """Mean size of model 1's error in the quarters of lowest and of highest tension of each cable, N."""
    force, error = found.tension_from_force, np.abs(found.tension_error(1))
    low, high = np.quantile(force, [0.25, 0.75], axis=0)
    return float(error[force <= low].mean()), float(error[force >= high].mean())
