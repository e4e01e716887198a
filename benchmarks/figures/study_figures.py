"""Figures of a record of study runs: rates over cases whose seeds nothing was set on, and the tables of benchmarks/study.md."""

from collections.abc import Mapping, Sequence
from itertools import chain, groupby

from benchmarks.figures.rate import Rate, rate
from benchmarks.figures.study_record import ScoredCase
from diagnosis.effects import EFFECTS
from xneck.study.score import NO_CAUSE_VERDICTS, EffectScore
from xneck.study.summary import summary_tables

STANDARD_SECONDS = (60.0, 60.0)
STANDARD_MANNER = "rich"


def study_figures(cases: Sequence[ScoredCase], tuned_seeds: Mapping[int, str]) -> dict[str, str]:
    """By name of the figure. Cases of `tuned_seeds` (seed: what was set on it) are counted in none of the rates."""
    counted = [case for case in cases if case.seed not in tuned_seeds]
    standard = [case for case in counted if is_standard(case)]
    other = [case for case in counted if not is_standard(case)]
    rates = standard_rates(standard)
    figures = {f"study.{name}": one.text for name, one in rates.items()}
    figures |= {f"study.{name}.percent": one.percent for name, one in rates.items()}
    figures |= {f"study.{name}.interval": one.interval for name, one in rates.items()}
    return figures | {
        "study.arms": str(len({case.seed for case in standard})),
        "study.cases": str(len(standard)),
        "study.made_from": _made_from(standard),
        "study.totals": _totals(rates),
        "study.tables": _tables(standard),
        "study.missed": _missed(counted),
        "study.other": _by_setting(other),
        "study.left_out": _left_out(cases, tuned_seeds),
    }


def is_standard(case: ScoredCase) -> bool:
    """Effects of normal size, rich motion, 60 s fitted and 60 s held out: what the headline's rates are of."""
    return case.scored.size == 1 and case.scored.manner == STANDARD_MANNER and case.seconds == STANDARD_SECONDS


def standard_rates(cases: Sequence[ScoredCase]) -> dict[str, Rate]:
    """Of all that is reported."""
    scores = [case.scored for case in cases]
    hidden = [s for s in scores if len(s.sightings) == 1 and s.sightings[0].known]
    outside = [s for s in scores if len(s.sightings) == 1 and not s.sightings[0].known]
    several = [s for s in scores if len(s.sightings) > 1]
    nothing = [s for s in scores if s.nothing]
    seen: list[EffectScore] = [s.sightings[0] for s in hidden]
    return {
        "named": rate(x.first for x in seen),
        "in_set": rate(x.listed for x in seen),
        "alone": rate(x.alone for x in seen),
        "place": rate(x.place for x in seen if x.place is not None),
        "numbers": rate(n.within for n in chain.from_iterable(x.numbers for x in seen)),
        "false": rate(bool(s.false) for s in hidden),
        "quiet": rate(s.verdict in NO_CAUSE_VERDICTS for s in nothing),
        "false_alarms": rate(bool(s.false) for s in nothing),
        "unknown": rate(s.verdict == "unknown" for s in outside),
        "outside_named": rate(bool(s.false) for s in outside),
        "pairs": rate(all(x.named for x in s.sightings) for s in several),
    }


_WORDS = {
    "named": "an effect is hidden: it is named first",
    "in_set": "it is named, or listed as indistinguishable from what is named",
    "alone": "it is named, and nothing else with it",
    "place": "it is named in its place, where it has one",
    "numbers": "its numbers are within 3 sigma",
    "false": "another cause is named that it cannot be taken for",
    "quiet": "nothing is hidden: nothing is said to be wrong",
    "false_alarms": "nothing is hidden: a cause is named",
    "unknown": "an effect of no catalogue is hidden: it is called unknown",
    "outside_named": "an effect of no catalogue is hidden: a cause is named",
    "pairs": "two effects are hidden: both are named",
}


def _totals(rates: Mapping[str, Rate]) -> str:
    rows = [f"| {_WORDS[name]} | {one.text} | {one.interval} |" for name, one in rates.items()]
    return "\n".join(["", "| what | how often | 95 % interval |", "|---|---:|---:|", *rows, ""])


def _made_from(cases: Sequence[ScoredCase]) -> str:
    """Seeds by the sources that ran them."""
    by_code: dict[str, set[int]] = {}
    for case in cases:
        by_code.setdefault(case.code, set()).add(case.seed)
    lines = [f"- Seeds {_ranges(sorted(seeds))}: sources {code}." for code, seeds in by_code.items()]
    return "\n".join(["", *(lines or ["- None yet."]), ""])


def _tables(cases: Sequence[ScoredCase]) -> str:
    scores = [case.scored for case in cases]
    outside = dict.fromkeys(x.effect for s in scores for x in s.sightings if x.effect not in EFFECTS)
    found = summary_tables(scores, [*outside, *EFFECTS]) if scores else ()
    return "\n\n".join(["", *(table.markdown().replace("## ", "### ", 1) for table in found), ""])


def _missed(cases: Sequence[ScoredCase]) -> str:
    """Every case that did not come out right."""
    wrong = [case for case in cases if not case.scored.right]
    lines = [
        f"- {case.scored.what.replace('+', ' with ')}, arm {case.seed}{_setting_words(case)}: "
        + (
            f"{case.scored.verdict}, {case.scored.said} named"
            if case.scored.said != case.scored.verdict
            else case.scored.said
        )
        + "."
        for case in wrong
    ]
    return "\n".join(["", *(lines or ["- None."]), ""])


def _setting_words(case: ScoredCase) -> str:
    if is_standard(case):
        return ""
    return f" ({case.scored.manner}, {case.seconds[0]:g} + {case.seconds[1]:g} s, size {case.scored.size:g})"


def _by_setting(cases: Sequence[ScoredCase]) -> str:
    """Motions and lengths other than the standard ones, a row each."""

    def setting(case: ScoredCase) -> tuple[str, tuple[float, float]]:
        return case.scored.manner, case.seconds

    rows = []
    for (manner, seconds), group in groupby(sorted(cases, key=setting), key=setting):
        rates = standard_rates(list(group))
        cells = (rates[name].text if rates[name].of else "-" for name in ("named", "false", "quiet", "unknown"))
        rows.append(f"| {manner} | {seconds[0]:g} + {seconds[1]:g} | {' | '.join(cells)} |")
    head = (
        "| motion | seconds | named first | a false cause | nothing hidden, nothing said | of no catalogue, unknown |"
    )
    return "\n".join(["", head, "|---|---:|---:|---:|---:|---:|", *rows, ""]) if rows else "\nNone yet.\n"


def _left_out(cases: Sequence[ScoredCase], tuned_seeds: Mapping[int, str]) -> str:
    """Seeds of the record that something was set on."""
    seeds = sorted({case.seed for case in cases} & set(tuned_seeds))
    lines = [f"- Arm {seed}: {tuned_seeds[seed]}" for seed in seeds]
    return "\n".join(["", *(lines or ["- None of those that were run."]), ""])


def _ranges(numbers: Sequence[int]) -> str:
    """Such as `100-104, 107`."""
    parts: list[list[int]] = []
    for n in numbers:
        if parts and n == parts[-1][-1] + 1:
            parts[-1].append(n)
        else:
            parts.append([n])
    return ", ".join(f"{p[0]}-{p[-1]}" if len(p) > 1 else f"{p[0]}" for p in parts)
