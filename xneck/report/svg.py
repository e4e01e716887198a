"""A matplotlib figure as SVG that lives inside a page: no outside name, small, and ids that do not clash."""

import re
from dataclasses import dataclass
from io import StringIO

from markupsafe import Markup, escape
from matplotlib.figure import Figure

from xneck.report.drawn import Storey, storeys

_REFERRED = re.compile(r'(?:url\(#|href="#)([^")]+)')
_NUMBERS = re.compile(r' (d|x|y)="([^"]*)"')
_LONG = re.compile(r"(-?\d+\.\d{2})\d+")


@dataclass(frozen=True)
class Panel:
    """One picture of a figure, and its numbers."""

    svg: Markup
    says: str
    storeys: tuple[Storey, ...]


def inline(figure: Figure, key: str, says: str) -> Panel:
    """`figure` as an <svg> element with what was drawn; `key` is unique in the page, `says` is read to those who do not see it."""
    stream = StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)  # the page's own style sheet has it once for all
    # matplotlib names every group; of two figures in one page, the second would be clipped with the first one's paths
    referred = set(_REFERRED.findall(text))
    text = re.sub(r' id="([^"]*)"', lambda found: f' id="{key}-{found[1]}"' if found[1] in referred else "", text)
    text = _REFERRED.sub(lambda found: found[0].replace(f"#{found[1]}", f"#{key}-{found[1]}"), text)
    text = _NUMBERS.sub(_shorter, text)
    text = re.sub(r"<defs>\s*</defs>", "", text)
    text = re.sub(r">\s+<", "><", text)
    box = re.search(r'viewBox="[^"]*"', text)
    assert box is not None
    head = f'<svg class="plot" {box[0]} role="img" aria-label="{escape(says)}">'
    return Panel(Markup(re.sub(r"^<svg[^>]*>", lambda _: head, text).strip()), says, storeys(figure))


def _shorter(found: re.Match[str]) -> str:
    """Coordinates to a hundredth of a point, without the spaces that SVG does not need."""
    short = _LONG.sub(r"\1", found[2]).replace("\n", "")
    short = re.sub(r" *([MLCQz]) *", r"\1", short).strip()
    return f' {found[1]}="{short}"'
