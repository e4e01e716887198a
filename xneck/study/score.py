"""What a diagnosis said, against what was hidden."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from diagnosis.effects import EFFECTS
from xneck.study.expected import expected
from xneck.study.plan import NOTHING

REFUSED = "refused"
NAMING = ("cause", "ambiguous")
"""verdicts that name something"""
QUIET = ("consistent", "insufficient")
"""verdicts that find nothing"""
VERDICTS = (*QUIET, "unknown", REFUSED)
"""what is said instead of a name"""


@dataclass(frozen=True)
class Number:
    """A parameter whose truth is known."""

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
        """3 sigma."""
        return self.z is not None and abs(self.z) <= 3


@dataclass(frozen=True)
class Sighting:
    """One effect that was hidden, and whether it was found."""

    effect: str
    known: bool
    """whether the catalogue of causes holds it"""
    first: bool
    """it was named, before any other"""
    named: bool
    """it was named"""
    listed: bool
    """it was named, or is among what a named cause cannot be told from"""
    alone: bool
    """nothing but what was hidden was named, and nothing stands beside its name"""
    place: bool | None
    """it was named where it is; None where it was not, or can only be in one place"""
    numbers: tuple[Number, ...]
    """of what was named, where the truth is a number of the same meaning"""


@dataclass(frozen=True)
class Score:
    """Of one case."""

    name: str
    what: str
    """what was hidden; none where its size was zero"""
    manner: str
    size: float
    verdict: str
    said: str
    """the first cause's name, or the verdict where it names none"""
    sightings: tuple[Sighting, ...]
    false: tuple[str, ...]
    """causes that were named, though nothing hidden is among what they cannot be told from"""
    ratio: float | None
    """rms that the extended model leaves of recordings not fitted, over noise alone, in the worse of the two equations"""
    ratio_before: float | None
    """the same of the base model"""

    @property
    def nothing(self) -> bool:
        return self.what == NOTHING

    @property
    def detected(self) -> bool:
        """Something was said to be wrong."""
        return self.verdict not in (*QUIET, REFUSED)

    @property
    def right(self) -> bool:
        """Nothing, said to be; what nobody knows, unknown; else all that was hidden and no more, as the first choice."""
        if self.nothing:
            return self.verdict in QUIET
        if not all(s.known for s in self.sightings):
            return self.verdict == "unknown"
        return not self.false and all(s.named for s in self.sightings)

    def as_json(self) -> dict[str, Any]:
        """All of it, and whether it is right."""
        return asdict(self) | {"detected": self.detected, "right": self.right}


def score(result: Mapping[str, Any]) -> Score:
    """Of the record that a case has written."""
    case = result["case"]
    hidden = result["truth"]["hidden"] if case["size"] else []
    diagnosis = result.get("diagnosis", {"verdict": REFUSED, "causes": [], "gains": []})
    verdict = diagnosis["verdict"]
    # a verdict that does not name has set aside what it lists
    causes = diagnosis["causes"] if verdict in NAMING else []
    sets = [{cause["effect"], *cause["indistinguishable_from"]} for cause in causes]
    effects = {h["effect"] for h in hidden}
    false = tuple(cause["effect"] for cause, one in zip(causes, sets, strict=True) if not one & effects)
    equations = [g for g in diagnosis["gains"] if g["unit"] != "rad"]
    ratios = [(g["after"] / g["noise_floor"], g["before"] / g["noise_floor"]) for g in equations]
    return Score(
        name=result["name"],
        what="+".join(h["effect"] for h in hidden) or NOTHING,
        manner=case["manner"],
        size=case["size"],
        verdict=verdict,
        said=causes[0]["effect"] if causes else verdict,
        sightings=tuple(_sighting(h, result["truth"], causes, sets, effects) for h in hidden),
        false=false,
        ratio=max((after for after, _ in ratios), default=None),
        ratio_before=max((before for _, before in ratios), default=None),
    )


def _sighting(
    hidden: Mapping[str, Any],
    truth: Mapping[str, Any],
    causes: list[dict[str, Any]],
    sets: list[set[str]],
    effects: set[str],
) -> Sighting:
    effect = hidden["effect"]
    own = next((cause for cause in causes if cause["effect"] == effect), None)
    single = effect in EFFECTS and EFFECTS[effect].terms[0].of == "arm"
    return Sighting(
        effect,
        known=effect in EFFECTS,
        first=bool(causes) and causes[0]["effect"] == effect,
        named=own is not None,
        listed=any(effect in one for one in sets),
        alone=own is not None and set().union(*sets) <= effects,
        place=None if own is None or single else own["where"] == hidden["where"],
        numbers=_numbers(own, hidden, truth) if own else (),
    )


def _numbers(cause: Mapping[str, Any], hidden: Mapping[str, Any], truth: Mapping[str, Any]) -> tuple[Number, ...]:
    found = {(p["name"], p["index"]): p for p in cause["parameters"]}
    return tuple(
        Number(*which, true, found[which]["value"], found[which]["sigma"])
        for which, true in expected(hidden, truth).items()
        if which in found
    )
