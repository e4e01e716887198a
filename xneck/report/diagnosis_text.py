"""The words of a diagnosis's page: its sentence, its key numbers and the rows of its tables."""

from collections.abc import Sequence
from math import degrees

from diagnosis import signature_record
from diagnosis.cause import Cause
from diagnosis.cause_ranking import CauseCandidate
from diagnosis.diagnose import Diagnosis, unlisted_law
from diagnosis.drawing_findings import furthest_in_words
from diagnosis.held_out_gain import Gain
from diagnosis.record import probability
from diagnosis.remainder import plainly_left
from diagnosis.simulated_gain import MEASURES
from xneck.report.key_number import KeyNumber
from xneck.report.number_text import number_text, percent, with_sigma
from xneck.report.words import join_words, with_spaces
from xneck_foundation.one_line import indexed
from xneck_foundation.parameter import Parameter
from xneck_foundation.unit_text import printed_unit, with_unit

_MAX_DRAWING = 12
"""numbers of the drawing that are listed"""
_MAX_ALIKE = 3
"""laws that explain as much, of each that is told"""
_MAX_CONSIDERED = 10
"""causes in the table of what else it could be"""


def diagnosis_sentence(d: Diagnosis) -> str:
    """The verdict in words: the cause, where it is, its size, and the gain on recordings that were not fitted."""
    told = ", and ".join(found.law.words for found in d.found_laws).replace("_", " ")
    if d.verdict == "unknown" and d.found_laws:
        return f"Something is wrong that no known cause explains, and a law is found that it follows: {told}.{_gain_sentence(d)}"
    if d.verdict == "unknown":
        signed = signature_record.words(d.signature, d.extended.arm.M).replace("+-", "±")
        told = signed if any(d.set_aside) else unlisted_law(d.search, d.found_laws) or signed
        return f"Something is wrong that no known cause explains: {told}.{_misfit_sentence(d)}"
    if d.verdict == "consistent":
        worst = int(d.before.ratio.argmax())
        name = signature_record.channel_names(d.extended.arm.M, d.extended.arm.N)[worst]
        far = furthest_in_words(d.drawing).replace("+-", "±")
        return (
            f"The simulation agrees with these recordings: what it leaves is noise in all {len(d.before.rms)} equations, "
            f"at most {d.before.ratio[worst]:.2f} times that ({name})."
            + (f" But that is of the arm as they tell it: {far}." if far else "")
        )
    if d.verdict == "insufficient":
        return f"These recordings cannot tell: {d.why}."
    parts = []
    for named, cause, parameters in zip(d.search.named, d.causes, d.numbers, strict=True):
        others = [c.effect.words for c in named.tied if c.effect is not cause.effect]
        what = f"{cause.effect.words} ({_place(cause)}{_sizes(cause, parameters)})"
        parts.append(f"{what}, or {', or '.join(others)}" if others else what)
    causes = "; and ".join(parts)
    if d.verdict == "ambiguous":
        causes = f"One of these, and the data cannot tell which: {causes}"
    beside = f"; and a law that no catalogue lists acts {told}" if d.found_laws else ""
    return f"{causes[0].upper()}{causes[1:]}{beside}.{_remains_sentence(d)}{_gain_sentence(d)}"


def _remains_sentence(d: Diagnosis) -> str:
    """What is left beside what is named, where that is plain."""
    plain = plainly_left(d.remainder)
    left = f"{plain[0].equation} is left with {plain[0].ratio:.1f} times noise" if plain else ""
    short = "something short and strong acts in stretches that were set aside" if any(d.set_aside) else ""
    said = ", and ".join(filter(None, [short, left]))
    return f" Something unknown remains: {said}." if said and d.something_remains else ""


def _place(cause: Cause) -> str:
    return "" if cause.where.label == "all" else f"{cause.where.label}; "


def _sizes(cause: Cause, parameters: Sequence[Parameter]) -> str:
    """Such as `tilt = 0.0841 ± 0.0008 rad`; with all values where the cause acts in several places."""
    first = [p for p in parameters if p.name == cause.effect.terms[0].name]
    values = ", ".join(with_sigma(p.value, p.sigma) for p in first)
    places = f" at {cause.effect.place}s {join_words([str(p.index) for p in first])}" if len(first) > 1 else ""
    return f"{first[0].name} = {with_unit(values, first[0].unit)}{places}"


def worst_equations(gains: Sequence[Gain]) -> Gain | None:
    """The kind of equations with the largest misfit, over noise, before the cause was added; None where there is none."""
    of_equations = [g for g in gains if g.measure not in MEASURES.values()]
    return max(of_equations, key=lambda g: g.before / g.noise_floor, default=None)


def _gain_sentence(d: Diagnosis) -> str:
    """What the extended model gains on recordings that were not fitted."""
    g = worst_equations(d.gains)
    if g is None:
        return " Not tried on recordings that were not fitted: none were given."
    before, after, noise = (number_text(rms, 3) for rms in (g.before, g.after, g.noise_floor))
    return (
        f" On recordings that were not fitted, the {g.measure} are off by {after} {g.unit} in place of {before} "
        f"(gain {with_sigma(g.before - g.after, g.sigma)}; noise alone: {noise}).{_tip_sentence(d)}"
    )


def shown_gain(g: Gain) -> Gain:
    """As people read it: joint angles in degrees."""
    if g.measure != MEASURES["alpha"]:
        return g
    return Gain(g.measure, "deg", *map(degrees, (g.before, g.after, g.noise_floor, g.sigma)))


def _tip_sentence(d: Diagnosis) -> str:
    if d.arm_error is None:
        return ""
    if d.arm_error.is_noise:
        noise = number_text(degrees(float(d.arm_error.joints_noise.max())), 2)
        return f" Simulated by its forces the arm shows no difference: even a true model may be off by {noise}° at a joint."
    before, after = (number_text(1e3 * off, 2) for off in (d.arm_error.tip_before, d.arm_error.tip_after))
    return f" The simulated tip is off by {after} mm in place of {before}."


def _misfit_sentence(d: Diagnosis) -> str:
    """How far the base model is off on recordings that were not fitted."""
    g = worst_equations(d.gains)
    if g is None:
        return ""
    return (
        f" On recordings that were not fitted, the {g.measure} are off by {number_text(g.before, 3)} {g.unit}, "
        f"{number_text(g.before / g.noise_floor, 3)} times noise."
    )


def diagnosis_key_numbers(d: Diagnosis) -> list[KeyNumber]:
    """The numbers below the sentence."""
    over_noise = d.before.rms / d.after.floor
    worst = int(over_noise.argmax())
    name = signature_record.channel_names(d.extended.arm.M, d.extended.arm.N)[worst]
    numbers = [KeyNumber("verdict", d.verdict, d.why or "one set of causes explains it")]
    if d.search.named:
        numbers.append(KeyNumber("explained", f"{100 * d.explained:.0f} %", "of what stood above noise"))
    now = f", now {number_text(d.after.ratio[worst], 3)}" if d.is_extended else ""
    numbers.append(KeyNumber("worst equation", name, f"{number_text(over_noise[worst], 3)} times noise{now}"))
    for g in map(shown_gain, d.gains):
        gain = f"{number_text(g.before, 3)} → {number_text(g.after, 3)}" if d.is_extended else number_text(g.before, 3)
        gain = f"{gain} {g.unit}".replace("N m", "N\u00a0m")
        numbers.append(
            KeyNumber(f"{g.measure}, not fitted", gain, f"noise alone {number_text(g.noise_floor, 3)} {g.unit}")
        )
    return numbers


def cause_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Rows of the table of causes: cause, where, parameter, value with sigma, unit, identified, probability."""
    rows = []
    for named, cause, parameters in zip(d.search.named, d.causes, d.numbers, strict=True):
        for p in parameters:
            label = indexed(p.name, p.index)
            certainty = percent(100 * probability(named))
            value = with_sigma(p.value, p.sigma)
            identified = "identified" if p.identified else "not to 10 %"
            unit = printed_unit(p.unit)
            rows.append((with_spaces(cause.effect.name), cause.where.label, label, value, unit, identified, certainty))
    return rows


def share_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Rows of the table of what each cause does: cause, where, and RMS in N, mN m and deg."""
    return [
        (
            with_spaces(cause.effect.name),
            cause.where.label,
            number_text(share.motors, 3),
            number_text(1e3 * share.arm, 3),
            "not simulated" if share.simulated_angle is None else number_text(degrees(share.simulated_angle), 3),
        )
        for cause, share in zip(d.causes, d.shares, strict=True)
    ]


def law_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Rows of the table of laws that no catalogue lists: law, number, value with sigma, unit, what explains as much."""
    rows = []
    for found in d.found_laws:
        others = "; ".join(law.words for law in found.law.alike[:_MAX_ALIKE]).replace("_", " ")
        for i, p in enumerate(found.law.parameters):
            label = indexed(p.name, p.index)
            value = with_sigma(p.value, p.sigma) if p.sigma else number_text(p.value, 3)
            words = found.law.words.replace("_", " ")
            rows.append((words if i == 0 else "", label, value, printed_unit(p.unit), others if i == 0 else ""))
    return rows


def unlisted_sentence(d: Diagnosis) -> str:
    """What function of one variable would explain most of what is left; empty where nothing is plainly left."""
    rest = d.search.unlisted
    if rest is None:
        return ""
    of = "what stands above noise" if not d.causes else "what the named causes leave above noise"
    share = f"{100 * rest.explains:.0f}\u00a0%"
    return (
        f"Of {of}, a law of the {rest.function.equation} that follows the {rest.function.follows} would explain {share}: "
        f"more than any other function of one variable."
    )


def channel_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """Columns and rows of the table of equations: RMS of noise, of the base model, and of the extended model if there is one."""
    names = signature_record.channel_names(d.extended.arm.M, d.extended.arm.N)
    titles, rows = ["equation", "unit", "noise alone", "base model", "over noise"], []
    floor = d.after.floor  # as in the record: noise alone of the arm with its causes
    for k, name in enumerate(names):
        row = [name, "N" if k < d.extended.arm.M else "N m", number_text(float(floor[k]), 3)]
        row += [number_text(float(d.before.rms[k]), 3), f"{d.before.rms[k] / floor[k]:.2f}"]
        if d.is_extended:
            row += [number_text(float(d.after.rms[k]), 3), f"{d.after.ratio[k]:.2f}"]
        rows.append(tuple(row))
    return [*titles, *(["extended model", "over noise"] if d.is_extended else [])], rows


def drawing_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Rows of the table of the drawing: number, what the arm has beyond it with sigma, unit, tolerance, how many tolerances."""
    rows = []
    for found in d.drawing[:_MAX_DRAWING]:
        scale, unit = (1e3, "mrad") if found.unit == "rad" else (100.0, "%")
        rows.append(
            (
                found.name,
                with_sigma(scale * found.value, scale * found.sigma),
                unit,
                number_text(scale * found.tolerance, 2),
                f"{abs(found.value) / found.tolerance:.1f}",
            )
        )
    return rows


def gain_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """Columns and rows of the table of equations on recordings that were not fitted, with the gain and its sigma."""
    titles, rows = ["equations", "unit", "noise alone", "base model"], []
    for g in map(shown_gain, d.gains):
        row = [g.measure, g.unit, number_text(g.noise_floor, 3), number_text(g.before, 3)]
        if d.is_extended:
            row += [number_text(g.after, 3), with_sigma(g.before - g.after, g.sigma)]
        rows.append(tuple(row))
    return [*titles, *(["extended model", "gain ± σ"] if d.is_extended else [])], rows


def considered_rows(d: Diagnosis) -> list[tuple[str, ...]]:
    """Rows of the table of causes that were considered: cause, where, meaning, and the share of the loss that it explains alone."""
    tied = {c.effect.name for named in d.search.named for c in named.tied}
    names = {cause.effect.name for cause in d.causes}

    def verdict(c: CauseCandidate) -> str:
        return "named" if c.effect.name in names else "as good" if c.effect.name in tied else ""

    return [
        (
            with_spaces(c.effect.name),
            c.where.label,
            c.effect.words,
            f"{100 * d.search.share_taken(c):.1f} %".replace("-", "\u2212"),
            verdict(c),
        )
        for c in d.search.ranking[:_MAX_CONSIDERED]
    ]


def pattern_table(d: Diagnosis) -> tuple[list[str], list[tuple[str, ...]]]:
    """Columns and rows of the table of conditions: the share of what stands above noise that each explains in each equation."""
    names = signature_record.channel_names(d.extended.arm.M, d.extended.arm.N)
    # a condition of the joints shares its row with the motors' condition of the same name
    conditions = list(dict.fromkeys(p.against for p in d.signature.patterns))
    by_place = {(p.channel, p.against): p for p in d.signature.patterns}
    rows = []
    for condition in conditions:
        patterns = [by_place.get((k, condition)) for k in range(len(names))]
        rows.append((condition, *("" if p is None else f"{100 * p.explains:.0f} %" for p in patterns)))
    return ["against", *names], rows
