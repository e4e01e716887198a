"""A diagnosis held against what was hidden."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from diagnosis.effects import EFFECTS
from xneck.study.expected import expected
from xneck.study.plan import NO_EFFECT

REFUSED_VERDICT = "refused"
NAMING_VERDICTS = ("cause", "ambiguous")
"""verdicts that name a cause"""
NO_CAUSE_VERDICTS = ("consistent", "insufficient")
"""verdicts by which nothing known or unknown is wrong"""
NAMELESS_VERDICTS = (*NO_CAUSE_VERDICTS, "unknown", REFUSED_VERDICT)
"""what stands in the tables where no cause is named"""
MAX_Z = 3.0
"""error of a parameter, in sigma, up to which it counts as right (docs/thresholds.md)"""


@dataclass(frozen=True)
class ParameterScore:
    """An estimated parameter beside its truth."""

    name: str
    index: int | None
    true: float
    found: float
    sigma: float | None

    @property
    def z(self) -> float | None:
        """Error in sigmas; None where there is no sigma."""
        return (self.found - self.true) / self.sigma if self.sigma else None

    @property
    def within(self) -> bool:
        """Whether the error is within MAX_Z sigma."""
        return self.z is not None and abs(self.z) <= MAX_Z


@dataclass(frozen=True)
class EffectScore:
    """One effect that was hidden, and whether it was found."""

    effect: str
    known: bool
    """whether the catalogue of causes holds it"""
    first: bool
    """whether it was named before any other"""
    named: bool
    listed: bool
    """whether it was named, or is indistinguishable from a cause that was"""
    alone: bool
    """whether it was named, and nothing that was not hidden was named or listed beside it"""
    place: bool | None
    """whether it was named in its true place; None where it was not named, or can only be in one place"""
    numbers: tuple[ParameterScore, ...]
    """its parameters, where the truth is a number of the same meaning"""


@dataclass(frozen=True)
class Score:
    """One case: what was hidden in it, and what the diagnosis said."""

    name: str
    what: str
    """the hidden effects joined with +; none where nothing was hidden, or its size was zero"""
    manner: str
    size: float
    verdict: str
    said: str
    """the first cause's name, or the verdict where it names none"""
    sightings: tuple[EffectScore, ...]
    """one for each hidden effect"""
    false: tuple[str, ...]
    """causes that were named though neither they nor what they are indistinguishable from was hidden"""
    ratio: float | None
    """rms of the extended model's residuals over that of noise, on the held-out recording, in the worse of the two equations"""
    ratio_before: float | None
    """rms of the base model's residuals over that of noise, likewise"""

    @property
    def nothing(self) -> bool:
        """Whether nothing was hidden."""
        return self.what == NO_EFFECT

    @property
    def detected(self) -> bool:
        """Whether the diagnosis said that something is wrong."""
        return self.verdict not in (*NO_CAUSE_VERDICTS, REFUSED_VERDICT)

    @property
    def right(self) -> bool:
        """Whether the verdict is right.

        Right are: no cause where nothing was hidden, `unknown` where an effect is outside the catalogue, and otherwise all hidden
        effects named and no other.
        """
        if self.nothing:
            return self.verdict in NO_CAUSE_VERDICTS
        if not all(s.known for s in self.sightings):
            return self.verdict == "unknown"
        return not self.false and all(s.named for s in self.sightings)

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON: all fields, and whether the case was detected and right."""
        return asdict(self) | {"detected": self.detected, "right": self.right}


def score_case(result: Mapping[str, Any]) -> Score:
    """The score of a case, from the record that it has written."""
    case = result["case"]
    hidden = result["truth"]["hidden"] if case["size"] else []
    diagnosis = result.get("diagnosis", {"verdict": REFUSED_VERDICT, "causes": [], "gains": []})
    verdict = diagnosis["verdict"]
    # other verdicts list causes that they have rejected
    causes = diagnosis["causes"] if verdict in NAMING_VERDICTS else []
    sets = [{cause["effect"], *cause["indistinguishable_from"]} for cause in causes]
    effects = {h["effect"] for h in hidden}
    false = tuple(cause["effect"] for cause, names in zip(causes, sets, strict=True) if not names & effects)
    equations = [g for g in diagnosis["gains"] if g["unit"] != "rad"]
    ratios = [(g["after"] / g["noise_floor"], g["before"] / g["noise_floor"]) for g in equations]
    return Score(
        name=result["name"],
        what="+".join(h["effect"] for h in hidden) or NO_EFFECT,
        manner=case["manner"],
        size=case["size"],
        verdict=verdict,
        said=causes[0]["effect"] if causes else verdict,
        sightings=tuple(_effect_score(h, result["truth"], causes, sets, effects) for h in hidden),
        false=false,
        ratio=max((after for after, _ in ratios), default=None),
        ratio_before=max((before for _, before in ratios), default=None),
    )


def _effect_score(
    hidden: Mapping[str, Any],
    truth: Mapping[str, Any],
    causes: list[dict[str, Any]],
    sets: list[set[str]],
    effects: set[str],
) -> EffectScore:
    effect = hidden["effect"]
    named = next((cause for cause in causes if cause["effect"] == effect), None)
    one_place = effect in EFFECTS and EFFECTS[effect].terms[0].of == "arm"
    return EffectScore(
        effect=effect,
        known=effect in EFFECTS,
        first=bool(causes) and causes[0]["effect"] == effect,
        named=named is not None,
        listed=any(effect in names for names in sets),
        alone=named is not None and set().union(*sets) <= effects,
        place=None if named is None or one_place else named["where"] == hidden["where"],
        numbers=_parameter_scores(named, hidden, truth) if named else (),
    )


def _parameter_scores(
    cause: Mapping[str, Any], hidden: Mapping[str, Any], truth: Mapping[str, Any]
) -> tuple[ParameterScore, ...]:
    estimates = {(p["name"], p["index"]): p for p in cause["parameters"]}
    return tuple(
        ParameterScore(*key, true, estimates[key]["value"], estimates[key]["sigma"])
        for key, true in expected(hidden, truth).items()
        if key in estimates
    )
