"""What a motion is to answer: effects by name, or what a diagnosis left open."""

from collections.abc import Sequence

import numpy as np

from diagnosis.cause_search import Search
from diagnosis.detectability import Detectability, visible_numbers
from diagnosis.diagnose import Diagnosis
from diagnosis.effect import Effect
from diagnosis.effects import EFFECTS
from diagnosis.look_alikes import NamedCause
from diagnosis.planned_motion import Question, Suspect, loss_alone
from diagnosis.record import look_alikes
from mechanism.arm import Arm, arm_of
from mechanism.description import Neck
from mechanism.laws import LAWS
from xneck_foundation.errors import Refused
from xneck_foundation.spelling import quoted, valid_words

_SCALINGS, _GROWTH = 6, 3.0
"""of an effect to what the recordings show, and the power by which its loss is taken to grow: from its square on, for what is
known counts the more, up to its fourth power"""


def effects_among(names: Sequence[str]) -> tuple[list[Effect], list[str]]:
    """Effects, and the names that are parameters of laws. Raises Refused where a name is neither."""
    parameters = list(dict.fromkeys(term.name for law in LAWS.values() for term in law.terms))
    for name in names:
        if name not in EFFECTS and name not in parameters:
            what = f"unknown effect or parameter {quoted(name)}"
            raise Refused("design --for", what, valid_words(name, [*EFFECTS, *parameters]))
    return [EFFECTS[name] for name in names if name in EFFECTS], [name for name in names if name not in EFFECTS]


def questions_about(effects: Sequence[Effect], neck: Neck, beside: Sequence[Effect] = ()) -> tuple[Question, ...]:
    """Whether each effect shows at a size that should, wherever it is; and is told from each other one, and from those beside."""
    out = []
    for effect in effects:
        suspects = _suspects(effect, neck)
        out.append(Question(suspects))
        out += [Question(suspects, other) for other in (*effects, *beside) if other is not effect]
    return tuple(out)


def open_questions(d: Diagnosis) -> tuple[Question, ...]:
    """What would settle a diagnosis; none where it is settled.

    Causes that explain alike are asked about as large as they must be to explain what the recordings show. Where causes do not
    hold on other recordings, each is asked about beside what could feign it. Else it is what the recordings could not show.
    """
    neck, search = d.extended.neck, d.search
    tied = [named for named in search.named if len(named.tied) > 1]
    if tied:
        return tuple(q for named in tied for q in _between(named, search))
    if d.verdict != "insufficient":
        return ()
    if search.named:
        named = [EFFECTS[n.effect.name] for n in search.named]
        feigning = {name: _feigning(d.detectability, name) for name in (e.name for e in named)}
        return tuple(q for e in named for q in questions_about([e], neck, feigning[e.name]))
    return questions_about_each(d.detectability.invisible, neck)


def questions_about_each(names: Sequence[str], neck: Neck) -> tuple[Question, ...]:
    """Whether each shows, whatever the others do."""
    return tuple(q for name in names for q in questions_about([EFFECTS[name]], neck))


def _suspects(effect: Effect, neck: Neck) -> tuple[Suspect, ...]:
    """In each single place, at the size that should show; everywhere, where it may not sit alone."""
    placements = effect.placements(arm_of(neck))
    return tuple(
        Suspect(effect, effect.start_shapes[0], w.columns, visible_numbers(effect, w.columns, neck))
        for w in (placements[1:] or placements)
    )


def _between(named: NamedCause, search: Search) -> list[Question]:
    """Each of a set that explains alike beside each other one."""
    nothing_else = search.every_effect.with_zero_residual()
    out = []
    for rival in named.tied:
        columns, effect = rival.where.columns, rival.effect
        cause = next((c for c in search.last.causes if c.effect is effect), None)
        one = Suspect(effect, effect.start_shapes[0], columns, np.ones(len(columns)))
        if cause is not None and np.any(cause.amounts):
            one = Suspect(effect, one.shape, columns, cause.amounts / effect.sizes(_arm(search))[list(columns)])
        else:
            for _ in range(_SCALINGS):
                scale = (named.gain / max(loss_alone(nothing_else, one), 1e-12)) ** (1 / _GROWTH)
                one = Suspect(effect, one.shape, columns, scale * one.numbers)
        out += [Question((one,), other.effect) for other in named.tied if other.effect is not effect]
    return out


def _arm(search: Search) -> Arm:
    return search.first.comparison.linearisation.hypothesis.arm


def _feigning(d: Detectability, name: str) -> list[Effect]:
    """Effects that could feign one in the recordings."""
    return [EFFECTS[pair["feigned_by"]] for pair in look_alikes(d) if pair["effect"] == name]
