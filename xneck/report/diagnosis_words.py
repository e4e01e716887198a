"""A diagnosis in sentences and in the rows of its tables."""

from collections.abc import Sequence

from diagnosis import signature_record
from diagnosis.cause import Cause
from diagnosis.cause_parameters import parameters_of
from diagnosis.cause_search import CauseCandidate
from diagnosis.diagnose import Diagnosis
from diagnosis.gain import Gain
from diagnosis.record import probability
from xneck.report.verdict import Figure
from xneck.report.wording import listed, number, percent, with_sigma
from xneck_foundation.least_squares import Parameter

_CONSIDERED = 10
"""causes in the table of what else it could be"""


def sentence(d: Diagnosis) -> str:
    """The verdict: what it is, where and how much, and what it gains where nothing was fitted."""
    if d.verdict == "unknown":
        signed = signature_record.words(d.signature, d.extended.arm.M).replace("+-", "±")
        return f"Something is wrong that no known cause explains: {signed}.{_before(d)}"
    if d.verdict == "consistent":
        worst = int(d.before.ratio.argmax())
        name = signature_record.channels(d.extended.arm.M, d.extended.arm.N)[worst]
        return (
            f"The simulation agrees with these recordings: what it leaves is noise in all {len(d.before.rms)} equations, "
            f"at most {d.before.ratio[worst]:.2f} times that ({name})."
        )
    if d.verdict == "insufficient":
        return f"These recordings cannot tell: {d.why}."
    parts = []
    for named, cause, own in zip(d.search.named, d.causes, parameters_of(d.search.last), strict=True):
        others = [c.effect.words for c in named.tied if c.effect is not cause.effect]
        what = f"{cause.effect.words} ({_placed(cause)}{_amounts(cause, own)})"
        parts.append(f"{what}, or {', or '.join(others)}" if others else what)
    head = "; and ".join(parts)
    head = (
        f"One of these, and the data cannot tell which: {head}"
        if d.verdict == "ambiguous"
        else head[0].upper() + head[1:]
    )
    return f"{head}.{_gained(d)}"


def _placed(cause: Cause) -> str:
    return "" if cause.where.label == "all" else f"{cause.where.label}; "


def _amounts(cause: Cause, parameters: Sequence[Parameter]) -> str:
    """`tilt = 0.0841 ± 0.0008 rad`; of several places in one go."""
    first = [p for p in parameters if p.name == cause.effect.terms[0].name]
    unit = "" if first[0].unit == "1" else f" {first[0].unit}"
    values = [with_sigma(p.value, p.sigma) for p in first]
    places = f" at {cause.effect.place}s {listed([str(p.index) for p in first])}" if len(first) > 1 else ""
    return f"{first[0].name} = {', '.join(values)}{unit}{places}"


def most_gained(gains: Sequence[Gain]) -> Gain | None:
    """The kind of equations that was worst."""
    return max(gains, key=lambda g: g.before / g.noise_floor, default=None)


def _gained(d: Diagnosis) -> str:
    g = most_gained(d.gains)
    if g is None:
        return " Not tried on recordings that were not fitted: none were given."
    return (
        f" On recordings that were not fitted, the {g.measure} are off by {number(g.after, 3)} {g.unit} in place of "
        f"{number(g.before, 3)} (gain {with_sigma(g.before - g.after, g.sigma)}; noise alone: {number(g.noise_floor, 3)})."
    )


def _before(d: Diagnosis) -> str:
    g = most_gained(d.gains)
    if g is None:
        return ""
    return (
        f" On recordings that were not fitted, the {g.measure} are off by {number(g.before, 3)} {g.unit}, "
        f"{number(g.before / g.noise_floor, 3)} times noise."
    )


def head(d: Diagnosis) -> list[Figure]:
    """The numbers below the sentence."""
    worst = int(d.before.ratio.argmax())
    name = signature_record.channels(d.extended.arm.M, d.extended.arm.N)[worst]
    out = [Figure("verdict", d.verdict, d.why or "one set of causes explains it")]
    if d.search.named:
        out += [
            Figure("explained", f"{100 * d.explained:.0f} %", "of what stood above noise"),
            Figure("worst equation", name, f"{d.before.ratio[worst]:.2f} times noise, now {d.after.ratio[worst]:.2f}"),
        ]
    else:
        out.append(Figure("worst equation", name, f"{d.before.ratio[worst]:.2f} times noise"))
    for g in d.gains:
        gain = f"{number(g.before, 3)} → {number(g.after, 3)}" if d.search.named else number(g.before, 3)
        gain = f"{gain} {g.unit}".replace("N m", "N\u00a0m")
        out.append(Figure(f"{g.measure}, not fitted", gain, f"noise alone {number(g.noise_floor, 3)} {g.unit}"))
    return out


def cause_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Cause, where, parameter, value with sigma, unit, whether it is identified, probability among its like."""
    rows = []
    for named, cause, own in zip(d.search.named, d.causes, parameters_of(d.search.last), strict=True):
        for p in own:
            label = p.name if p.index is None else f"{p.name}({p.index})"
            sure = f"{percent(100 * probability(named))}"
            value = with_sigma(p.value, p.sigma)
            told = "identified" if p.identified else "not to 10 %"
            rows.append((spoken(cause.effect.name), cause.where.label, label, value, p.unit, told, sure))
    return rows


def channel_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """Head and rows: equation, unit, RMS of noise alone, of the base model and over noise; of the extended one if there is one."""
    names = signature_record.channels(d.extended.arm.M, d.extended.arm.N)
    titles, rows = ["equation", "unit", "noise alone", "base model", "over noise"], []
    for k, name in enumerate(names):
        row = [name, "N" if k < d.extended.arm.M else "N m", number(float(d.before.floor[k]), 3)]
        row += [number(float(d.before.rms[k]), 3), f"{d.before.ratio[k]:.2f}"]
        if d.search.named:
            row += [number(float(d.after.rms[k]), 3), f"{d.after.ratio[k]:.2f}"]
        rows.append(tuple(row))
    return [*titles, *(["extended model", "over noise"] if d.search.named else [])], rows


def gain_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """The same where nothing was fitted, with the gain and its sigma."""
    titles, rows = ["equations", "unit", "noise alone", "base model"], []
    for g in d.gains:
        row = [g.measure, g.unit, number(g.noise_floor, 3), number(g.before, 3)]
        if d.search.named:
            row += [number(g.after, 3), with_sigma(g.before - g.after, g.sigma)]
        rows.append(tuple(row))
    return [*titles, *(["extended model", "gain ± σ"] if d.search.named else [])], rows


def considered_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Cause, where, what it means, and the share of the loss that it explains alone."""
    whole = d.search.first.loss
    tied = {c.effect.name for named in d.search.named for c in named.tied}
    names = {cause.effect.name for cause in d.causes}

    def verdict(c: CauseCandidate) -> str:
        return "named" if c.effect.name in names else "as good" if c.effect.name in tied else ""

    return [
        (spoken(c.effect.name), c.where.label, c.effect.words, f"{100 * max(c.gain, 0.0) / whole:.1f} %", verdict(c))
        for c in d.search.rankings[0][:_CONSIDERED]
    ]


def pattern_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """Head and rows: of every condition the share that its bins explain of what stands above noise in each equation."""
    names = signature_record.channels(d.extended.arm.M, d.extended.arm.N)
    # joints' conditions stand beside the motors' of the same kind
    against = list(dict.fromkeys(p.against for p in d.signature.patterns))
    found = {(p.channel, p.against): p for p in d.signature.patterns}
    rows = []
    for a in against:
        own = [found.get((k, a)) for k in range(len(names))]
        rows.append((a, *("" if p is None else f"{100 * p.explains:.0f} %" for p in own)))
    return ["against", *names], rows


def spoken(name: str) -> str:
    """An effect's name as people write it."""
    return name.replace("_", " ")
