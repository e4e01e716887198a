"""Figures of the catalogue of effects: how many there are, their names, and the table of causes."""

from diagnosis.effect import Effect
from diagnosis.effects import EFFECTS


def catalogue_figures() -> dict[str, str]:
    """By name of the figure."""
    return {
        "effects.count": str(len(EFFECTS)),
        "effects.names": names(),
        "effects.table": table(),
    }


def names() -> str:
    """All names, separated by commas."""
    return ", ".join(f"`{name}`" for name in EFFECTS)


def table() -> str:
    """A row for each effect: its words, its numbers with their units, and what tells it."""
    rows = [f"| `{e.name}` | {e.words} | {_numbers(e)} | {e.would_tell} |" for e in EFFECTS.values()]
    return "\n".join(["", "| cause | what is wrong | numbers | what tells it |", "|---|---|---|---|", *rows, ""])


def _numbers(effect: Effect) -> str:
    terms = (*effect.terms, *effect.shape_terms)
    return ", ".join(term.name + ("" if term.unit == "1" else f" ({term.unit})") for term in terms)
