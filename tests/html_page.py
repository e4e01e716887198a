"""A report's page as its parts, and as a browser shows it."""

import json
import re
from collections import Counter
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from playwright.sync_api import Page

from xneck.report import template
from xneck.report.figures_file import figures_beside


class Elements(HTMLParser):
    """Every start tag with its attributes, and the visible text; open elements must be closed in order."""

    VOID = frozenset(("meta", "link", "img", "br", "hr", "input"))

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data.replace("\N{NO-BREAK SPACE}", " ")


class Tables(HTMLParser):
    """Every table of a page as rows of texts, head first, under the heading that stands before it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.under: dict[str, list[list[str]]] = {}
        self._heading, self._into = "", ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in ("h2", "h3"):
            self._heading = ""
        if tag == "table":
            self.under[self._heading] = []
        if tag == "tr":
            self.under[self._heading].append([])
        if tag in ("td", "th"):
            self.under[self._heading][-1].append("")
        if tag in ("h2", "h3", "td", "th"):
            self._into = tag

    def handle_endtag(self, tag: str) -> None:
        if tag == self._into:
            self._into = ""

    def handle_data(self, data: str) -> None:
        if self._into in ("h2", "h3"):
            self._heading += data
        elif self._into:
            self.under[self._heading][-1][-1] += data.replace("\N{NO-BREAK SPACE}", " ")


SCRIPT = Path(template.__file__).with_name("plot_cursor.js")
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def read_number(text: str) -> float:
    """A number as a page writes it, without its unit and sigma."""
    plain = text.split(" ± ")[0].removesuffix(" %").replace("\u2009", "").replace("\u2212", "-")
    mantissa, _, power = plain.partition(" × 10")
    return float(mantissa) * 10 ** int(power.translate(SUPERSCRIPTS) or 0)


def check_alone(report: Path, elements: Elements) -> None:
    """Ids are unique, every reference has its target, and nothing is fetched from elsewhere, nor run but the pages' own script."""
    ids = Counter(attributes["id"] for _, attributes in elements.tags if "id" in attributes)
    assert max(ids.values()) == 1
    text = report.read_text(encoding="utf-8")
    assert set(re.findall(r'(?:url\(#|href="#)([^")]+)', text)) <= set(ids)
    assert re.findall(r"<script.*?</script>", text, re.DOTALL) == [
        f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>"
    ]
    for tag, attributes in elements.tags:
        assert tag not in ("iframe", "object", "base", "form")
        for name in ("src", "href", "xlink:href", "srcset", "action"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:")), (tag, name, value)


def look(page: Page, report: Path, width: int) -> None:
    """No error, no request but the file itself, nothing wider than the screen, every figure drawn and named, every anchor there.

    As one sees it who asks for less motion: anchors are reached at once."""
    watched = watch(page)
    page.emulate_media(media="screen", reduced_motion="reduce")
    page.set_viewport_size({"width": width, "height": 844})
    page.goto(report.as_uri())
    page.wait_for_load_state("networkidle")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    drawn = page.evaluate("[...document.querySelectorAll('svg.plot')].map(s => s.getBoundingClientRect().height)")
    assert all(height > 100 for height in drawn)
    assert page.evaluate(NAMELESS) == []
    for link in page.locator("nav a").all():
        link.click()
        place = str(link.get_attribute("href"))
        assert page.url == report.as_uri() + place
        page.wait_for_function(ARRIVED, arg=place)
    watched.check([report])


PHONE = 390
"""px, width of a usual phone"""


def tables_wider_than_a_phone(page: Page, report: Path) -> list[str]:
    """Tables that are not folded away and must be scrolled sideways on a phone, by how they begin."""
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": PHONE, "height": 844})
    page.goto(report.as_uri())
    return page.evaluate(
        """[...document.querySelectorAll('.scroll')].filter(s => s.checkVisibility() && s.scrollWidth > s.clientWidth)
        .map(s => `${s.scrollWidth} of ${s.clientWidth}: ${s.textContent.trim().slice(0, 60)}`)"""
    )


NAMELESS = """[...document.querySelectorAll('img, svg, a, summary')]
    .filter(e => e.getAttribute('aria-hidden') !== 'true' && !(e.getAttribute('alt') || e.getAttribute('aria-label')
        || e.tagName !== 'svg' && e.textContent.trim())).map(e => e.outerHTML)"""
"""pictures, figures and links that nobody hears of who does not see them"""
ARRIVED = """place => { const top = document.querySelector(place).getBoundingClientRect().top;
    return top >= -1 && top < innerHeight; }"""


@dataclass(frozen=True)
class Watched:
    """What a page said and asked for since it was watched."""

    complaints: list[str]
    requests: list[str]

    def check(self, pages: list[Path]) -> None:
        """No error or dialog; nothing was asked for but these files."""
        assert self.complaints == []
        asked = {url.split("#")[0] for url in self.requests if not url.startswith("data:")}
        assert asked == {path.as_uri() for path in pages}


def watch(page: Page) -> Watched:
    """From now on; not those that were set to watch before."""
    watched = Watched([], [])
    page.on("console", lambda message: watched.complaints.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: watched.complaints.append(str(error)))
    page.on("dialog", lambda dialog: watched.complaints.append(f"dialog: {dialog.message}"))
    page.on("request", lambda request: watched.requests.append(request.url))
    return watched


PAPER = round(182 / 25.4 * 96)
"""px: A4 less the margins that the style sheet asks for"""
CUT_OFF = """width => [...document.body.querySelectorAll('*')].filter(e => !e.closest('svg') || e.matches('svg'))
    .filter(e => e.getBoundingClientRect().right > width + 1 || e.scrollWidth > e.clientWidth + 1 && e.clientWidth
        && getComputedStyle(e).overflowX !== 'visible').map(e => e.tagName + ' ' + e.textContent.trim().slice(0, 60))"""
COVERED = """[...document.querySelectorAll('td, th')].filter(e => getComputedStyle(e).position === 'sticky').length"""


def check_print(page: Page, report: Path) -> None:
    """On A4 nothing is cut off or covered, what is folded on the screen is there, and there are pages."""
    page.emulate_media(media="print")
    page.set_viewport_size({"width": PAPER, "height": 1016})
    page.goto(report.as_uri())
    assert page.evaluate(CUT_OFF, PAPER) == []
    assert page.evaluate(COVERED) == 0
    folded = "[...document.querySelectorAll('details > :not(summary)')].filter(e => !e.checkVisibility()).length"
    assert page.evaluate(folded) == 0
    printed = page.pdf(prefer_css_page_size=True)
    page.emulate_media(media="screen")
    pages = [tuple(map(float, box)) for box in re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", printed)]
    assert pages
    assert all(abs(w - 595) < 1 and abs(h - 842) < 1 for w, h in pages)


def check_figures(report: Path, elements: Elements) -> dict[str, list[dict[str, Any]]]:
    """Every figure of the page is in the file beside it, every panel with what it shows; all axes by their panel's words."""
    figures = json.loads(figures_beside(report).read_text(encoding="utf-8"))["figures"]
    panels = {panel["panel"]: panel["axes"] for figure in figures for panel in figure["panels"]}
    shown = Counter(
        str(attributes["aria-label"]) for _, attributes in elements.tags if attributes.get("class") == "plot"
    )
    assert Counter(panel["panel"] for figure in figures for panel in figure["panels"]) == shown
    for words, axes in panels.items():
        for storey in axes:
            assert storey["marks"], words
            assert words == "share of what each effect does that each other one could feign" or storey["y"], words
    return panels


def label_faults(page: Page, report: Path) -> list[str]:
    """Texts that leave their figure, as the browser lays it out, and texts of one figure that overlap."""
    page.set_viewport_size({"width": 1280, "height": 844})
    page.goto(report.as_uri())
    return page.evaluate(
        """() => [...document.querySelectorAll('svg.plot')].flatMap(svg => {
            const frame = svg.getBoundingClientRect();
            const labels = [...svg.querySelectorAll('text')].map(t => [t.textContent, t.getBoundingClientRect()]);
            const outside = labels.filter(([, r]) => r.left < frame.left - 1 || r.right > frame.right + 1
                || r.top < frame.top - 1 || r.bottom > frame.bottom + 1).map(([text]) => text + ' outside');
            const overlapping = labels.flatMap(([a, p], i) => labels.slice(i + 1).filter(([, q]) =>
                Math.min(p.right, q.right) - Math.max(p.left, q.left) > 1.5
                && Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 3).map(([b]) => a + ' over ' + b));
            return [...outside, ...overlapping].map(fault => svg.getAttribute('aria-label') + ': ' + fault);
        })"""
    )
