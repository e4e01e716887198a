"""The cases of a study, each with all settings that its recordings are generated from."""

import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from xneck_foundation.errors import Refused
from xneck_foundation.spelling import quoted, valid_words

NO_EFFECT = "none"


@dataclass(frozen=True)
class Case:
    """One pair of recordings of one arm."""

    kinds: tuple[str, ...]
    """effects that are hidden; empty where none is"""
    seed: int
    manner: str
    """how the arm moves"""
    size: float
    """of all effects that are hidden; 1 is normal"""
    noise_deg: float
    seconds: tuple[float, float]
    """length of the recording that is fitted, and of the one that is held out"""

    @property
    def effects(self) -> str:
        """The hidden effects, such as `none` or `base_tilt+cable_slack`."""
        return "+".join(self.kinds) or NO_EFFECT

    @property
    def name(self) -> str:
        """Name of the case's files; cases of other settings have other names."""
        fitted, held_out = self.seconds
        settings = f"size{self.size:g}-noise{self.noise_deg:g}-{fitted:g}+{held_out:g}s"
        return f"{self.effects}-{self.seed}-{self.manner.replace(' ', '_')}-{settings}"

    def as_json(self) -> dict[str, Any]:
        """All settings."""
        return asdict(self) | {"kinds": list(self.kinds), "seconds": list(self.seconds)}


@dataclass(frozen=True)
class StudyOptions:
    """Which cases a study has."""

    effects: tuple[tuple[str, ...], ...]
    """sets of effects, each hidden with every seed"""
    seeds: range
    """one arm each"""
    pairs: int
    """number of further cases, with two effects at random"""
    manners: tuple[str, ...]
    """how the arm moves"""
    size: tuple[float, float]
    """range that the size of an effect is drawn from"""
    noise_deg: float
    seconds: tuple[float, float]
    """length of the recording that is fitted, and of the one that is held out"""

    def as_json(self) -> dict[str, Any]:
        """The settings as study.json has them."""
        return {
            "effects": ["+".join(kinds) or NO_EFFECT for kinds in self.effects],
            "seeds": len(self.seeds),
            "first_seed": self.seeds.start,
            "pairs": self.pairs,
            "manners": list(self.manners),
            "size": list(self.size),
            "noise_deg": self.noise_deg,
            "seconds": list(self.seconds),
        }


def planned_cases(options: StudyOptions, catalogue: Sequence[str]) -> tuple[Case, ...]:
    """All sets of effects with each seed, then the pairs from the catalogue, in each manner; a seed's cases stand together.

    A case depends on its seed and effects alone: longer studies hold the cases of shorter ones.
    """

    def case(kinds: tuple[str, ...], seed: int, manner: str) -> Case:
        return Case(
            kinds=kinds,
            seed=seed,
            manner=manner,
            size=_size(kinds, seed, options.size),
            noise_deg=options.noise_deg,
            seconds=options.seconds,
        )

    cases = [case(kinds, seed, m) for seed in options.seeds for kinds in options.effects for m in options.manners]
    first_seed = options.seeds.start
    for seed in range(first_seed, first_seed + options.pairs):
        both = np.random.default_rng([seed, zlib.crc32(b"pair")]).choice(len(catalogue), 2, replace=False)
        pair = tuple(catalogue[int(i)] for i in sorted(both))
        cases += [case(pair, seed, manner) for manner in options.manners]
    return tuple(dict.fromkeys(cases))


def _size(kinds: tuple[str, ...], seed: int, size: tuple[float, float]) -> float:
    """The case's size, drawn evenly from the range; 1 where nothing is hidden."""
    if not kinds:
        return 1.0
    rng = np.random.default_rng([seed, zlib.crc32("+".join(kinds).encode())])
    return round(float(rng.uniform(*size)), 3)


def effect_sets(words: Sequence[str], kinds: Sequence[str], catalogue: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The sets of effects that `--effects` asks for: all, catalogue, outside, none, a name, or names with `+`; commas between.

    Raises Refused for a name that is not in `kinds`.
    """
    groups = {
        "all": [NO_EFFECT, *kinds],
        "catalogue": list(catalogue),
        "outside": [kind for kind in kinds if kind not in catalogue],
    }
    sets: list[tuple[str, ...]] = []
    for word in (part.strip() for given in words for part in given.split(",")):
        for effects in groups.get(word, [word]):
            names = () if effects == NO_EFFECT else tuple(effects.split("+"))
            if unknown := [name for name in names if name not in kinds]:
                valid = valid_words(unknown[0], [*groups, NO_EFFECT, *kinds])
                raise Refused("study", f"unknown effect {quoted(unknown[0])}", valid)
            # in the generator's order, so that one set has one name
            sets.append(tuple(kind for kind in kinds if kind in names))
    return tuple(dict.fromkeys(sets))
