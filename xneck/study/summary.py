"""The tables of a study: how often hidden effects were named, how well, and what was named falsely."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np

from xneck.study.count_table import CountTable
from xneck.study.plan import NO_EFFECT
from xneck.study.score import NAMELESS_VERDICTS, NO_CAUSE_VERDICTS, EffectScore, Score

Item = TypeVar("Item")

_SIZE_BINS = 4
"""bins of sizes, with equally many cases each"""


def summary_tables(scores: Sequence[Score], order: Sequence[str]) -> tuple[CountTable, ...]:
    """All tables that these scores fill; effects are listed in the given order."""
    ranks = {effect: i for i, effect in enumerate([NO_EFFECT, *order])}
    single = sorted((s for s in scores if len(s.sightings) <= 1), key=lambda s: ranks[s.what])
    several = [s for s in scores if len(s.sightings) > 1]
    made = [
        _confusion_table(single, ranks),
        _catalogue_table(single),
        _false_alarm_table(single),
        _size_table(single),
        _manner_table(scores),
        _pair_table(several),
    ]
    return tuple(table for table in made if table is not None and table.rows)


def _confusion_table(scores: Sequence[Score], ranks: dict[str, int]) -> CountTable:
    """Rows: what was hidden. Columns: what was named first, by its row's number, or said instead."""
    said = {s.said for s in scores}
    numbers = {effect: f"{i}" for effect, i in ranks.items()}
    names = sorted(said - set(NAMELESS_VERDICTS), key=lambda name: ranks.get(name, len(ranks)))
    columns = [*names, *(v for v in NAMELESS_VERDICTS if v in said)]
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        counts = Counter(s.said for s in group)
        rows.append((f"{numbers[what]} {what}", *(str(counts[c]) if counts[c] else "." for c in columns)))
    return CountTable(
        "What was hidden (rows), and what was named first",
        ("hidden", *(numbers.get(c, c) for c in columns)),
        tuple(rows),
        "Columns of a number: the cause of that number was named first.",
    )


def _catalogue_table(scores: Sequence[Score]) -> CountTable:
    """How often each effect of the catalogue was found, and how well."""
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        if group[0].nothing:
            continue
        effects = [s.sightings[0] for s in group]
        if effects[0].known:
            rows.append((what, str(len(group)), *_rates(group, effects), _residual_ratios(group)))
    every = [s for s in scores if s.sightings and s.sightings[0].known]
    if len(rows) > 1:
        rows.append(("all", str(len(every)), *_rates(every, [s.sightings[0] for s in every]), _residual_ratios(every)))
    return CountTable(
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


def _rates(group: Sequence[Score], effects: Sequence[EffectScore]) -> tuple[str, ...]:
    numbers = [n for s in effects for n in s.numbers]
    z = [n.z for n in numbers if n.z is not None]
    places = [s.place for s in effects if s.place is not None]
    return (
        _fraction(s.detected for s in group),
        _fraction(s.first for s in effects),
        _fraction(s.listed for s in effects),
        _fraction(s.alone for s in effects),
        _fraction(places) if places else "-",
        _fraction(n.within for n in numbers) if numbers else "-",
        f"{np.sqrt(np.mean(np.square(z))):.1f}" if z else "-",
        _fraction(bool(s.false) for s in group),
    )


def _residual_ratios(group: Sequence[Score]) -> str:
    """Median ratio of residuals to noise of the base and of the extended model."""
    both = [(s.ratio_before, s.ratio) for s in group if s.ratio_before is not None and s.ratio is not None]
    if not both:
        return "-"
    before, after = np.median(both, axis=0)
    return f"{before:.3g} -> {after:.3g}"


def _false_alarm_table(scores: Sequence[Score]) -> CountTable:
    """What was said where nothing was hidden, and where an effect outside the catalogue was."""
    rows = []
    for what, group in _grouped(scores, lambda s: s.what).items():
        if not group[0].nothing and group[0].sightings[0].known:
            continue
        named = [bool(s.false) for s in group]
        rows.append(
            (
                what,
                str(len(group)),
                _fraction(named),
                _interval(sum(named), len(named)),
                _fraction(s.verdict == "unknown" for s in group),
                _fraction(s.verdict in NO_CAUSE_VERDICTS for s in group),
                "quiet" if group[0].nothing else "unknown",
            )
        )
    return CountTable(
        "False alarms",
        ("hidden", "cases", "a cause named", "95 %", "unknown", "quiet", "right is"),
        tuple(rows),
        "Quiet: consistent or insufficient. 95 %: the interval of the rate of false names, after Clopper and Pearson.",
    )


def _size_table(scores: Sequence[Score]) -> CountTable | None:
    """How many were named first and detected, by size; None where all sizes are the same."""
    with_size = [s for s in scores if s.sightings and s.sightings[0].known]
    sizes = np.array([s.size for s in with_size])
    if len(sizes) == 0 or np.ptp(sizes) == 0:
        return None
    edges = np.unique(np.quantile(sizes, np.linspace(0, 1, _SIZE_BINS + 1)))
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
    return CountTable(
        "Detection against size",
        ("hidden", *columns),
        tuple(rows),
        "Cases named first, detected, and all, of a size (1 is normal).",
    )


def _manner_table(scores: Sequence[Score]) -> CountTable | None:
    """How many were named, by manner of motion; None where there is one manner only."""
    groups = _grouped(scores, lambda s: s.manner)
    if len(groups) < 2:
        return None
    rows = []
    for manner, group in groups.items():
        effects = [s.sightings[0] for s in group if len(s.sightings) == 1 and s.sightings[0].known]
        quiet = [bool(s.false) for s in group if s.nothing]
        outside = [s.verdict == "unknown" for s in group if s.sightings and not all(x.known for x in s.sightings)]
        cells = (
            _fraction(x.first for x in effects),
            _fraction(x.listed for x in effects),
            _fraction(quiet),
            _fraction(outside),
        )
        rows.append((manner, str(len(group)), *cells))
    return CountTable(
        "By manner of motion",
        ("manner", "cases", "named first", "in the set", "named though none", "outside said unknown"),
        tuple(rows),
    )


def _pair_table(scores: Sequence[Score]) -> CountTable | None:
    """Cases with several effects at once, each a row, and counts of all in the note."""
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
    all_named = [n == len(s.sightings) for n, s in zip(named, scores, strict=True)]
    listed = [all(x.listed for x in s.sightings) for s in scores]
    return CountTable(
        "Several at once",
        ("hidden", "named first", "the first", "the second", "false causes"),
        tuple(rows),
        f"All named: {_fraction(all_named)}; all in the sets: {_fraction(listed)}; "
        f"one or more named: {_fraction(n > 0 for n in named)}; none false: {_fraction(not s.false for s in scores)}.",
    )


def _grouped(scores: Sequence[Item], key: Callable[[Item], str]) -> dict[str, list[Item]]:
    out: dict[str, list[Item]] = {}
    for s in scores:
        out.setdefault(key(s), []).append(s)
    return out


def _fraction(values: Iterable[bool]) -> str:
    """How many of the values are true, such as 3/4."""
    flags = list(values)
    return f"{sum(flags)}/{len(flags)}"


def _interval(count: int, total: int) -> str:
    from scipy.stats import binomtest

    low, high = binomtest(count, total).proportion_ci()
    return f"{100 * low:.0f}..{100 * high:.0f} %"
