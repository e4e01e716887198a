"""Figures of a diagnosis: residuals against what they depend on, residuals over time, and which causes look alike."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from diagnosis.detectability import Detectability
from diagnosis.residual_conditions import ALONG
from diagnosis.signature import CONSTANT, Pattern, Signature
from xneck.report import style
from xneck.report.figure_block import FigureBlock, LegendEntry
from xneck.report.number_text import number_text
from xneck.report.recorded_axes import RecordedAxes
from xneck.report.svg import SvgPanel, svg_panel
from xneck.report.words import join_words

Array = NDArray[np.float64]

BEFORE, AFTER = style.MODELS[3], style.MODELS[1]
_SHADES = ("#FFFFFF", "#E3E3E3", "#B5B5B5", "#6FA3CD", "#174E80")
_LEVELS = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
"""bounds of the shades: the share of an effect's loss that another effect could imitate"""


def equation_name(channel: int, motors: int) -> str:
    """Name of the equation of a channel, such as `motor 2` or `joint 1`; the motors come first."""
    return f"motor {channel + 1}" if channel < motors else f"joint {channel - motors + 1}"


def proof_figure(s: Signature, motors: int) -> FigureBlock:
    """The figure that proves a verdict without a cause: what the base model leaves, where it stands out most."""
    if s.kind == "episodes":
        worst = sorted(s.channels, key=lambda k: -max(float(np.max(c.before[k] / c.noise[k])) for c in s.courses))[:2]
        return FigureBlock(
            "When it errs",
            f"What the base model leaves in {join_words([equation_name(k, motors) for k in sorted(worst)])}, RMS of every "
            f"{number_text(s.courses[0].window_s, 2)} s: at noise for most of the time, and far above it now and then.",
            tuple(_course(s, k, motors, False, "proof") for k in sorted(worst)),
            _legend(False),
        )
    p = proof_pattern(s)
    if s.kind == "nothing":
        caption = "Where it stands highest: the bins' means stay within the band of noise alone, and the RMS is about noise's."
    else:
        share = f", {100 * s.best.explains:.0f} % of what stands above noise there"
        caption = f"Every bin's mean{share if s.best.explains else ''}, and its RMS."
    caption += " The band is what noise alone leaves (1 σ of a row)."
    if p.drum_wave is not None:
        caption += f" The drum's angle is folded into one of {number_text(p.drum_wave.order, 3)} waves a turn."
    return FigureBlock(
        f"What is left at {equation_name(p.channel, motors)}, against {p.against}",
        caption,
        (_means(p, motors, False, "proof"), _spread(p, motors, False, "proof")),
        _legend(False),
    )


def proof_pattern(s: Signature) -> Pattern:
    """The best pattern; for a constant residual, its pattern against the joint's angle or the cable's tension."""
    if s.best.against != CONSTANT:
        return s.best
    of_channel = [p for p in s.patterns if p.channel == s.best.channel]
    return next((p for p in of_channel if p.against == "joint's angle"), of_channel[0])


def residuals_over_time(s: Signature, motors: int, changed: bool) -> FigureBlock:
    """RMS of the residuals of every channel, window by window."""
    count = len(s.courses[0].noise)
    return FigureBlock(
        "Over time",
        f"RMS of every {number_text(s.courses[0].window_s, 2)} s"
        + (", one recording after the other." if len(s.courses) > 1 else ".")
        + " The band ends at what noise alone leaves.",
        tuple(_course(s, k, motors, changed, "time") for k in range(count)),
        _legend(changed),
    )


def residuals_by_condition(s: Signature, motors: int, changed: bool) -> FigureBlock | None:
    """For every channel above noise, the residuals against the condition that explains most of them, where one is clear."""
    clear = {p.channel: [q for q in s.clear if q.channel == p.channel and q.against != CONSTANT] for p in s.patterns}
    best = [max(patterns, key=lambda p: p.explains) for patterns in clear.values() if patterns]
    panels = tuple(_means(p, motors, changed, f"by{p.channel}") for p in best)
    if not panels:
        return None
    return FigureBlock(
        "Against what each depends on most",
        "Of every equation the condition whose bins explain most of what is above noise, where chance does not and the base model "
        "could not.",
        panels,
        _legend(changed),
    )


def confusion_matrix(detectability: Detectability) -> FigureBlock:
    """The share of each effect that each other one could imitate in these recordings."""
    count = len(detectability.effects)
    figure = Figure(figsize=(style.WIDTH, style.WIDTH))
    axes = RecordedAxes(figure, (0.37, 0.02, 0.61, 0.9))
    level = np.clip(np.digitize(detectability.imitated, _LEVELS[1:-1]), 0, len(_SHADES) - 1)
    for shade, colour in enumerate(_SHADES[1:], start=1):
        rows, columns = np.nonzero((level == shade) & ~np.eye(count, dtype=bool))
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            if not detectability.shown[row]:
                continue
            axes.fill([column, column + 1, column + 1, column], [row, row, row + 1, row + 1], color=colour, linewidth=0)
    for k in range(count):
        axes.fill([k, k + 1, k + 1, k], [k, k, k + 1, k + 1], color=style.MUTED, alpha=0.35, linewidth=0)
    names = [
        f"{n.replace('_', ' ')}{'*' if n in detectability.invisible else ''}  {k + 1}"
        for k, n in enumerate(detectability.effects)
    ]
    axes.record(
        "feigned by the effect of the column",
        "shades",
        x=detectability.effects,
        y=detectability.effects,
        share=detectability.imitated,
    )
    axes.set_xlim(0, count)
    axes.set_ylim(count, 0)
    axes.set_yticks(np.arange(count) + 0.5, names)
    axes.set_xticks(np.arange(count) + 0.5, [str(k + 1) for k in range(count)])
    axes.tick_params(length=0, labelsize=7.0)
    axes.xaxis.tick_top()
    axes.grid(visible=False)
    legend = [
        LegendEntry(f"{100 * low:.0f} to {100 * high:.0f} %", colour, "broad")
        for low, high, colour in zip(_LEVELS[1:-1], _LEVELS[2:], _SHADES[1:], strict=True)
    ]
    return FigureBlock(
        "Which causes these recordings could tell apart",
        "A row an effect, of the size that should show; a column another one, by its number. Shaded is the share of what the first "
        "does that the second could feign: dark pairs cannot be told apart here. Effects with a star would not show at all.",
        (svg_panel(figure, "alike", "share of what each effect does that each other one could feign"),),
        tuple(legend),
    )


def axis_words(p: Pattern) -> str:
    """The label of the horizontal axis, with its unit."""
    return p.against if p.unit in ("turn", "wave", "") else f"{p.against.removesuffix(ALONG)} ({p.unit})"


def _legend(changed: bool) -> tuple[LegendEntry, ...]:
    base = (LegendEntry("base model", BEFORE, "dashed" if changed else "solid"),)
    extended = (LegendEntry("extended model", AFTER),) if changed else ()
    return (*base, *extended, LegendEntry("noise alone", style.UNDERLAY, "band"))


def _means(p: Pattern, motors: int, changed: bool, key: str) -> SvgPanel:
    figure, axes = style.one_row_panel()
    factor = unit_factor(p.channel, motors)
    style.band(axes, "noise alone", p.bin_middles, -factor * p.noise, factor * p.noise, style.UNDERLAY)
    axes.axhline(0, color=style.MUTED, linewidth=0.7)
    _lines(axes, p.bin_middles, factor * p.before, factor * p.after, changed)
    axes.set_ylabel(f"mean left{ALONG if p.against.endswith(ALONG) else ''}, {equation_unit(p.channel, motors)}")
    return _finished(figure, axes, p, motors, f"{key}-mean")


def _spread(p: Pattern, motors: int, changed: bool, key: str) -> SvgPanel:
    figure, axes = style.one_row_panel()
    factor = unit_factor(p.channel, motors)
    style.band(axes, "noise alone", p.bin_middles, 0 * p.noise, factor * p.noise, style.UNDERLAY)
    _lines(axes, p.bin_middles, factor * p.before_rms, factor * p.after_rms, changed)
    axes.set_ylim(bottom=0)
    axes.set_ylabel(f"RMS left, {equation_unit(p.channel, motors)}")
    return _finished(figure, axes, p, motors, f"{key}-rms")


def _finished(figure: Figure, axes: RecordedAxes, p: Pattern, motors: int, key: str) -> SvgPanel:
    name = equation_name(p.channel, motors)
    axes.set_title(f"{name}, against {p.against}", color=equation_colour(p.channel, motors))
    if p.unit in ("turn", "wave"):
        axes.set_xlim(0, 1)
        axes.set_xlabel(f"part of a {p.unit}")
    else:
        axes.set_xlabel(axis_words(p))
    return svg_panel(figure, key, f"what is left at {name} against {p.against}")


def _course(s: Signature, channel: int, motors: int, changed: bool, key: str) -> SvgPanel:
    figure, axes = style.one_row_panel(2.0)
    at, before, after, noise = [], [], [], []
    for c, start in zip(s.courses, _starts(s), strict=True):
        at.append(np.append(start + c.window_starts + c.window_s / 2, np.nan))
        before.append(np.append(c.before[channel], np.nan))
        after.append(np.append(c.after[channel], np.nan))
        noise.append(np.append(np.full(len(c.window_starts), c.noise[channel]), np.nan))
    time, factor = np.concatenate(at), unit_factor(channel, motors)
    floor = factor * np.concatenate(noise)
    style.band(axes, "noise alone", time, 0 * floor, floor, style.UNDERLAY)
    _lines(axes, time, factor * np.concatenate(before), factor * np.concatenate(after), changed, dots=False)
    axes.set_ylim(bottom=0)
    name = equation_name(channel, motors)
    axes.set_title(name, color=equation_colour(channel, motors))
    axes.set_ylabel(f"RMS, {equation_unit(channel, motors)}")
    axes.set_xlabel("time, s")
    return svg_panel(figure, f"{key}{channel}", f"what is left at {name} over time")


def _starts(s: Signature) -> Sequence[float]:
    lengths = [float(c.window_starts[-1] + c.window_s) for c in s.courses]
    return [0.0, *np.cumsum(lengths)[:-1].tolist()]


def _lines(axes: RecordedAxes, x: Array, before: Array, after: Array, changed: bool, dots: bool = True) -> None:
    style.line(axes, "base model", x, before, BEFORE, "dashed" if changed else "solid", 1.3)
    if changed:
        style.line(axes, "extended model", x, after, AFTER, width=1.3)
    if dots:
        style.dots(axes, "base model's bins", x, before, BEFORE, 4.0)
        if changed:
            style.dots(axes, "extended model's bins", x, after, AFTER, 4.0)


def equation_unit(channel: int, motors: int) -> str:
    """The unit that is shown of an equation."""
    return "N" if channel < motors else "mN m"


def unit_factor(channel: int, motors: int) -> float:
    """Factor from SI to the unit that is shown."""
    return 1.0 if channel < motors else 1e3


def equation_colour(channel: int, motors: int) -> str:
    """Of the motor's cable, or of the joint."""
    return style.cable_colour(channel) if channel < motors else style.joint_colour(channel - motors)
