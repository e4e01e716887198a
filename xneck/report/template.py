"""The page templates beside this file, filled with values, the one style sheet and the one script."""

import base64
import hashlib
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup


def render(name: str | Path, **values: object) -> str:
    """The template `name` (or a file elsewhere, by its path) filled with `values`.

    Names without a value are errors, and values are shown as text, never as markup, unless they are Markup.
    """
    home = files("xneck.report")

    def load(template: str) -> str:
        return home.joinpath(template).read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(load), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    style_sheet = Markup(load("report.css"))  # our own file, not a person's
    if isinstance(name, Path):
        template = environment.from_string(name.read_text(encoding="utf-8"))
    else:
        template = environment.get_template(name)
    script = Markup(load("plot_cursor.js"))
    page = template.render(style_sheet=style_sheet, script=script, script_hash=_content_hash(script), **values)
    return page.replace("± ", "±\N{NO-BREAK SPACE}")  # a line does not end between a number and its sigma's sign


def _content_hash(script: str) -> Markup:
    """By which a page's policy lets the browser run this script and no other (CSP level 2, hash-source)."""
    return Markup("sha256-" + base64.b64encode(hashlib.sha256(script.encode()).digest()).decode())
