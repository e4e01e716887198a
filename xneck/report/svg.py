"""A matplotlib figure as SVG that lives inside a page: no outside name, small, and ids that do not clash."""

import re
from dataclasses import dataclass
from io import StringIO

from markupsafe import Markup, escape
from matplotlib.figure import Figure

from xneck.report.recorded_axes import AxesRecord, RecordedAxes, axes_records
from xneck.report.style import LOG_TIME

_REFERRED = re.compile(r'(?:url\(#|href="#)([^")]+)')
_NUMBERS = re.compile(r' (d|x|y)="([^"]*)"')
_LONG = re.compile(r"(-?\d+\.\d{2})\d+")


@dataclass(frozen=True)
class SvgPanel:
    """One picture of a figure block, and its numbers."""

    svg: Markup
    description: str
    """read to those who do not see it"""
    axes: tuple[AxesRecord, ...]


def svg_panel(figure: Figure, key: str, description: str) -> SvgPanel:
    """`figure` as an <svg> element with what was drawn; `key` is unique in the page, `description` is for
    those who do not see it."""
    stream = StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)  # the page's own style sheet has it once for all
    # matplotlib names every group; in one page, a second figure would be clipped with the first one's paths
    referred = set(_REFERRED.findall(text))
    text = re.sub(r' id="([^"]*)"', lambda match: f' id="{key}-{match[1]}"' if match[1] in referred else "", text)
    text = _REFERRED.sub(lambda match: match[0].replace(f"#{match[1]}", f"#{key}-{match[1]}"), text)
    text = _NUMBERS.sub(_shortened, text)
    text = re.sub(r"<defs>\s*</defs>", "", text)
    text = re.sub(r">\s+<", "><", text)
    box = re.search(r'viewBox="[^"]*"', text)
    assert box is not None
    head = f'<svg class="plot" {box[0]}{_time_axis(figure)} role="img" aria-label="{escape(description)}">'
    return SvgPanel(Markup(re.sub(r"^<svg[^>]*>", lambda _: head, text).strip()), description, axes_records(figure))


def _time_axis(figure: Figure) -> str:
    """Where the recording's time runs in a figure: left, right, top and bottom in points, and the times at left and right, s."""
    axes = [a for a in figure.axes if isinstance(a, RecordedAxes)]
    if not any(a.get_xlabel() == LOG_TIME for a in axes):
        return ""
    width, height = 72 * figure.get_figwidth(), 72 * figure.get_figheight()
    boxes = [a.get_position() for a in axes]
    top, bottom = min(1 - box.y1 for box in boxes) * height, max(1 - box.y0 for box in boxes) * height
    places = (boxes[0].x0 * width, boxes[0].x1 * width, top, bottom)
    begin, end = axes[0].get_xlim()
    return f' data-time="{" ".join(f"{place:.2f}" for place in places)} {begin:.4f} {end:.4f}"'


def _shortened(match: re.Match[str]) -> str:
    """Coordinates to a hundredth of a point, without the spaces that SVG does not need."""
    short = _LONG.sub(r"\1", match[2]).replace("\n", "")
    short = re.sub(r" *([MLCQz]) *", r"\1", short).strip()
    return f' {match[1]}="{short}"'
