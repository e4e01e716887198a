"""The pictures that prove causes: what the base model leaves where each acts, beside the cause as fitted."""

from diagnosis.cause import Cause
from diagnosis.cause_picture import CausePicture
from diagnosis.free_function import FreeFit
from diagnosis.law_gains import GainedLaw
from mechanism.arm import Arm
from xneck.report import style
from xneck.report.cause_drawing import place_words
from xneck.report.diagnosis_figures import AFTER, BEFORE, equation_colour, equation_name, equation_unit, unit_factor
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.svg import SvgPanel, svg_panel

_SHOWN_UNITS = {
    "rad": ("deg", 57.29577951308232),
    "m": ("mm", 1e3),
    "m/s": ("mm/s", 1e3),
    "turn": ("part of a turn", 1.0),
}
"""of the variables: as people read them, and the factor"""
_NOISE = "noise alone"


def cause_figure(cause: Cause, picture: CausePicture, arm: Arm, number: int, of: int) -> FigureBlock:
    """Of a named cause, the `number`-th of so many."""
    words, name = cause.effect.words, equation_name(picture.channel, arm.M)
    several = len(cause.effect.place_labels(arm)) > 1
    where = f", {place_words(cause, arm)}" if several else ""
    most = f", where it does most: {name}" if several and cause.where.label == "all" else f": {name}"
    others = " and with all others" if of > 1 else ""
    caption = (
        f"What the model leaves without this cause{others}{most}. Dots are means of rows that lie side by side along "
        f"the variable; the line is what the cause does as it was fitted, by the same rows. {_band_words(picture)}"
    )
    panel = _curve(picture, arm.M, f"cause{number}", "the cause as fitted")
    return FigureBlock(f"{words[0].upper()}{words[1:]}{where}", caption, (panel,), _legend("the cause as fitted"))


def law_figure(found: GainedLaw, picture: CausePicture, motors: int, number: int) -> FigureBlock:
    """Of a law that was found, the `number`-th."""
    law, name = found.law, equation_name(picture.channel, motors)
    caption = (
        f"What the model leaves without this law, where it does most: {name}. Dots are means of rows that lie side by side along "
        f"the variable; the line is the law as it was fitted, {law.equation}, by the same rows. {_band_words(picture)}"
    )
    words = law.words[0].upper() + law.words[1:]
    panel = _curve(picture, motors, f"law{number}", "the law as fitted")
    return FigureBlock(words.replace("_", " "), caption, (panel,), _legend("the law as fitted"))


def unlisted_figure(fit: FreeFit, picture: CausePicture, motors: int) -> FigureBlock:
    """Of a law that nobody listed."""
    function = fit.function
    caption = (
        f"What is left without this law, in the equation in which it does most: {equation_name(picture.channel, motors)}. Dots are "
        f"means of rows that lie side by side along the variable; the line is a smooth function of it, fitted in the equations of "
        f"all {function.equation}. {_band_words(picture)}"
    )
    panel = _curve(picture, motors, "unlisted", "function as fitted")
    return FigureBlock(f"What follows the {function.follows}", caption, (panel,), _legend("function as fitted"))


def _band_words(picture: CausePicture) -> str:
    along = " All is read along the motion: what rubs is positive." if picture.shown_by.along_motion else ""
    return f"The band is what noise alone leaves in a row (1 σ).{along}"


def _legend(fitted: str) -> tuple[LegendEntry, ...]:
    return (
        LegendEntry("left by the model without it", BEFORE, "dot"),
        LegendEntry(fitted, AFTER),
        LegendEntry(_NOISE, style.UNDERLAY, "band"),
    )


def _curve(picture: CausePicture, motors: int, key: str, fitted: str) -> SvgPanel:
    figure, axes = style.one_row_panel(3.2)
    by, factor = picture.shown_by, unit_factor(picture.channel, motors)
    unit, scale = _SHOWN_UNITS.get(by.unit, (by.unit, 1.0))
    at = scale * picture.bin_middles
    style.band(axes, _NOISE, at, -factor * picture.noise, factor * picture.noise, style.UNDERLAY)
    axes.axhline(0, color=style.MUTED, linewidth=0.7)
    style.line(axes, fitted, at, factor * picture.done, AFTER, width=1.6)
    style.dots(axes, "left by the model without it", at, factor * picture.left, BEFORE, 5.0)
    name, along = equation_name(picture.channel, motors), ", along the motion" if by.along_motion else ""
    axes.set_title(f"{name}, against {by.name}", color=equation_colour(picture.channel, motors))
    axes.set_xlabel(f"{by.name}, {unit}")
    if by.is_cyclic:
        axes.set_xlim(0, 1)
    axes.set_ylabel(f"mean left{along}, {equation_unit(picture.channel, motors)}")
    return svg_panel(
        figure, key, f"what is left at {name} without the cause, against {by.name}, and what the cause does ({key})"
    )
