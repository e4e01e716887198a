"""What a study found: the tables that its scores make."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np

from xneck.study.plan import NOTHING
from xneck.study.score import QUIET, VERDICTS, Score, Sighting
from xneck.study.table import Table

T = TypeVar("T")

_BINS = 4
"""of sizes, with as many cases each"""


def tables(scores: Sequence[Score], order: Sequence[str]) -> tuple[Table, ...]:
    """All that the scores give rise to; `order` is that of the effects."""
    known = {effect: i for i, effect in enumerate([NOTHING, *order])}
    single = sorted((s for s in scores if len(s.sightings) <= 1), key=lambda s: known[s.what])
    several = [s for s in scores if len(s.sightings) > 1]
    made = [
        _confusion(single, known),
        _found(single),
        _false_alarms(single),
        _by_size(single),
        _by_manner(scores),
        _pairs(several),
    ]
    return tuple(table for table in made if table is not None and table.rows)


def _confusion(scores: Sequence[Score], known: dict[str, int]) -> Table:
    """Rows: what was hidden. Columns: what was named first, by its row's number, or said instead."""
    said = {s.said for s in scores}
    numbers = {effect: f"{i}" for effect, i in known.items()}
    names = sorted(said - set(VERDICTS), key=lambda name: known.get(name, len(known)))
    columns = [*names, *(v for v in VERDICTS if v in said)]
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        counts = Counter(s.said for s in group)
        rows.append((f"{numbers[what]} {what}", *(str(counts[c]) if counts[c] else "." for c in columns)))
    return Table(
        "What was hidden (rows), and what was named first",
        ("hidden", *(numbers.get(c, c) for c in columns)),
        tuple(rows),
        "Columns of a number: the cause of that number was named first.",
    )


def _found(scores: Sequence[Score]) -> Table:
    """How often each effect of the catalogue was found, and how well."""
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        if group[0].nothing:
            continue
        seen = [s.sightings[0] for s in group]
        if seen[0].known:
            rows.append((what, str(len(group)), *_rates(group, seen), *_leftover(group)))
    every = [s for s in scores if s.sightings and s.sightings[0].known]
    if len(rows) > 1:
        rows.append(("all", str(len(every)), *_rates(every, [s.sightings[0] for s in every]), *_leftover(every)))
    return Table(
        "Effects of the catalogue, hidden one at a time",
        (
            "hidden", "cases", "detected", "named first", "in the set", "alone", "right place", "within 3 sigma", "rms z",
            "false causes", "left/noise",
        ),
        tuple(rows),
        "In the set: named, or listed as indistinguishable from what is named. Alone: named, and nothing else with it. Within "
        "3 sigma: of the numbers of what was named, where truth and law have the same form; rms z is their error in sigmas. False "
        "causes: cases with a cause whose set does not hold what was hidden. Left/noise: median, before -> after, on recordings "
        "not fitted.",
    )  # fmt: skip


def _rates(group: Sequence[Score], seen: Sequence[Sighting]) -> tuple[str, ...]:
    numbers = [n for s in seen for n in s.numbers]
    z = [n.z for n in numbers if n.z is not None]
    places = [s.place for s in seen if s.place is not None]
    return (
        _of(s.detected for s in group),
        _of(s.first for s in seen),
        _of(s.listed for s in seen),
        _of(s.alone for s in seen),
        _of(places) if places else "-",
        _of(n.within for n in numbers) if numbers else "-",
        f"{np.sqrt(np.mean(np.square(z))):.1f}" if z else "-",
        _of(bool(s.false) for s in group),
    )


def _leftover(group: Sequence[Score]) -> tuple[str]:
    both = [(s.ratio_before, s.ratio) for s in group if s.ratio_before is not None and s.ratio is not None]
    if not both:
        return ("-",)
    before, after = np.median(both, axis=0)
    return (f"{before:.3g} -> {after:.3g}",)


def _false_alarms(scores: Sequence[Score]) -> Table:
    """What is said where nothing is hidden, and where something is that nobody knows."""
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        if not group[0].nothing and group[0].sightings[0].known:
            continue
        named = [bool(s.false) for s in group]
        rows.append(
            (
                what,
                str(len(group)),
                _of(named),
                _interval(sum(named), len(named)),
                _of(s.verdict == "unknown" for s in group),
                _of(s.verdict in QUIET for s in group),
                "quiet" if group[0].nothing else "unknown",
            )
        )
    return Table(
        "False alarms",
        ("hidden", "cases", "a cause named", "95 %", "unknown", "quiet", "right is"),
        tuple(rows),
        "Quiet: consistent or insufficient. 95 %: the interval of the rate of false names, after Clopper and Pearson.",
    )


def _by_size(scores: Sequence[Score]) -> Table | None:
    """Named first, and detected, against size; none where all sizes are the same."""
    with_size = [s for s in scores if s.sightings and s.sightings[0].known]
    sizes = np.array([s.size for s in with_size])
    if len(sizes) == 0 or np.ptp(sizes) == 0:
        return None
    edges = np.unique(np.quantile(sizes, np.linspace(0, 1, _BINS + 1)))
    which = np.clip(np.searchsorted(edges, sizes, side="right") - 1, 0, len(edges) - 2)
    rows = []
    groups = _grouped(list(range(len(with_size))), lambda i: with_size[i].what)
    if len(groups) > 1:
        groups["all"] = list(range(len(with_size)))
    for what, members in groups.items():
        cells = []
        for b in range(len(edges) - 1):
            group = [with_size[i] for i in members if which[i] == b]
            detected, first = sum(s.detected for s in group), sum(s.sightings[0].first for s in group)
            cells.append(f"{first} {detected} {len(group)}" if group else "-")
        rows.append((what, *cells))
    columns = [f"{a:.2g}..{b:.2g}" for a, b in pairwise(edges)]
    return Table(
        "Detection against size",
        ("hidden", *columns),
        tuple(rows),
        "Cases named first, detected, and all, of a size (1 is normal).",
    )


def _by_manner(scores: Sequence[Score]) -> Table | None:
    """None where there is one manner."""
    groups = _grouped(scores, lambda s: s.manner)
    if len(groups) < 2:
        return None
    rows = []
    for manner, group in groups.items():
        seen = [s.sightings[0] for s in group if len(s.sightings) == 1 and s.sightings[0].known]
        quiet = [bool(s.false) for s in group if s.nothing]
        outside = [s.verdict == "unknown" for s in group if s.sightings and not all(x.known for x in s.sightings)]
        cells = (_of(x.first for x in seen), _of(x.listed for x in seen), _of(quiet), _of(outside))
        rows.append((manner, str(len(group)), *cells))
    return Table(
        "By manner of motion",
        ("manner", "cases", "named first", "in the set", "named though none", "outside said unknown"),
        tuple(rows),
    )


def _pairs(scores: Sequence[Score]) -> Table | None:
    """Several effects at once, by what was hidden, and in all."""
    if not scores:
        return None
    rows = [
        (
            s.what,
            s.said,
            *(["yes" if x.named else "listed" if x.listed else "no" for x in s.sightings[:2]]),
            ", ".join(s.false) or "-",
        )
        for s in scores
    ]
    named = [sum(x.named for x in s.sightings) for s in scores]
    all_of = [n == len(s.sightings) for n, s in zip(named, scores, strict=True)]
    listed = [all(x.listed for x in s.sightings) for s in scores]
    return Table(
        "Several at once",
        ("hidden", "named first", "the first", "the second", "false causes"),
        tuple(rows),
        f"All named: {_of(all_of)}; all in the sets: {_of(listed)}; one or more named: {_of(n > 0 for n in named)}; "
        f"none false: {_of(not s.false for s in scores)}.",
    )


def _grouped(scores: Sequence[T], key: Callable[[T], str]) -> dict[str, list[T]]:
    out: dict[str, list[T]] = {}
    for s in scores:
        out.setdefault(key(s), []).append(s)
    return out


def _of(values: Iterable[bool]) -> str:
    """Such as 3/4."""
    known = list(values)
    return f"{sum(known)}/{len(known)}"


def _interval(count: int, of: int) -> str:
    from scipy.stats import binomtest

    low, high = binomtest(count, of).proportion_ci()
    return f"{100 * low:.0f}..{100 * high:.0f} %"
