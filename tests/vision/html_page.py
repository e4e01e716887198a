"""A report's page as its parts, and as a browser shows it."""

import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

from playwright.sync_api import Page


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
        self.text += data


def check_alone(report: Path, elements: Elements) -> None:
    """Ids are unique, every reference has its target, and nothing is fetched from elsewhere or run."""
    ids = Counter(attributes["id"] for _, attributes in elements.tags if "id" in attributes)
    assert max(ids.values()) == 1
    text = report.read_text(encoding="utf-8")
    assert set(re.findall(r'(?:url\(#|href="#)([^")]+)', text)) <= set(ids)
    for tag, attributes in elements.tags:
        assert tag not in ("script", "iframe", "object", "base", "form")
        for name in ("src", "href", "xlink:href", "srcset", "action"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:")), (tag, name, value)


def look(page: Page, report: Path, width: int) -> None:
    """No error, no request but the file itself, nothing wider than the screen, every figure drawn."""
    complaints: list[str] = []
    requests: list[str] = []
    page.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("dialog", lambda dialog: complaints.append(f"dialog: {dialog.message}"))
    page.on("request", lambda request: requests.append(request.url))
    page.set_viewport_size({"width": width, "height": 844})
    page.goto(report.as_uri())
    page.wait_for_load_state("networkidle")
    assert complaints == []
    assert [url for url in requests if not url.startswith("data:")] == [report.as_uri()]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    drawn = page.evaluate("[...document.querySelectorAll('svg.plot')].map(s => s.getBoundingClientRect().height)")
    assert all(height > 100 for height in drawn)


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
