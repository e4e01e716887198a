"""A figure of the page: panels of one kind side by side, one legend for all of them, one caption."""

from dataclasses import dataclass
from typing import Literal

from markupsafe import Markup

from xneck.report.style import DASHES
from xneck.report.svg import SvgPanel

LegendMark = Literal["solid", "dashed", "dotted", "broad", "dot", "band"]


@dataclass(frozen=True)
class LegendEntry:
    """A line of a legend."""

    label: str
    colour: str
    mark: LegendMark = "solid"

    @property
    def swatch(self) -> Markup:
        """The mark as it is drawn in the panels."""
        draw = {
            "dot": '<circle cx="14" cy="6" r="3" fill="{0}"/>',
            "broad": '<path d="M1 6H27" stroke="{0}" stroke-width="5"/>',
            "band": '<rect x="1" y="1" width="26" height="10" fill="{0}" fill-opacity="0.3"/>',
        }.get(self.mark, '<path d="M1 6H27" stroke="{0}" stroke-width="2.4" stroke-dasharray="{1}"/>')
        inner = Markup(draw).format(self.colour, DASHES.get(self.mark, ""))
        return Markup('<svg class="swatch" viewBox="0 0 28 12" aria-hidden="true">{}</svg>').format(inner)


@dataclass(frozen=True)
class FigureBlock:
    """Panels (SVG), two in a row where the screen is wide enough; `caption` says in a sentence what to see."""

    title: str
    caption: str
    panels: tuple[SvgPanel, ...]
    legend: tuple[LegendEntry, ...] = ()
