"""What a study runs: cases, each with everything that its recordings are made from."""

import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from xneck_foundation.errors import Refused

NOTHING = "none"


@dataclass(frozen=True)
class Case:
    """One pair of recordings of one arm."""

    kinds: tuple[str, ...]
    """what is hidden; none where empty"""
    seed: int
    manner: str
    size: float
    """of all that is hidden, 1 is normal"""
    noise_deg: float
    seconds: tuple[float, float]
    """of the recording that is fitted, and of the one that is held out"""

    @property
    def what(self) -> str:
        """Such as `none`, or `base_tilt+cable_slack`."""
        return "+".join(self.kinds) or NOTHING

    @property
    def name(self) -> str:
        """Of its files; other settings have another one."""
        fitted, held_out = self.seconds
        settings = f"size{self.size:g}-noise{self.noise_deg:g}-{fitted:g}+{held_out:g}s"
        return f"{self.what}-{self.seed}-{self.manner.replace(' ', '_')}-{settings}"

    def as_json(self) -> dict[str, Any]:
        """All settings."""
        return asdict(self) | {"kinds": list(self.kinds), "seconds": list(self.seconds)}


def plan(
    effects: Sequence[tuple[str, ...]],
    pairs: int,
    catalogue: Sequence[str],
    seeds: range,
    manners: Sequence[str],
    size: tuple[float, float],
    noise_deg: float,
    seconds: tuple[float, float],
) -> tuple[Case, ...]:
    """All `effects` with each seed, then `pairs` of the catalogue's, in each manner; a seed's cases stand together.

    A case depends on its seed and effects alone: longer studies hold the cases of shorter ones.
    """
    cases = [
        Case(kinds, seed, manner, _size(kinds, seed, size), noise_deg, seconds)
        for seed in seeds
        for kinds in effects
        for manner in manners
    ]
    for seed in range(seeds.start, seeds.start + pairs):
        both = np.random.default_rng([seed, zlib.crc32(b"pair")]).choice(len(catalogue), 2, replace=False)
        pair = tuple(catalogue[int(i)] for i in sorted(both))
        cases += [Case(pair, seed, manner, _size(pair, seed, size), noise_deg, seconds) for manner in manners]
    return tuple(dict.fromkeys(cases))


def _size(kinds: tuple[str, ...], seed: int, size: tuple[float, float]) -> float:
    """Drawn evenly; what hides nothing has none to draw."""
    if not kinds:
        return 1.0
    rng = np.random.default_rng([seed, zlib.crc32("+".join(kinds).encode())])
    return round(float(rng.uniform(*size)), 3)


def effects_of(words: Sequence[str], kinds: Sequence[str], catalogue: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """What `--effects` asks for, in words or lists with commas: all, catalogue, outside, none, a name, or names with `+`.

    Raises Refused for a name that is not in `kinds`.
    """
    groups = {
        "all": [NOTHING, *kinds],
        "catalogue": list(catalogue),
        "outside": [kind for kind in kinds if kind not in catalogue],
    }
    out: list[tuple[str, ...]] = []
    for word in (part.strip() for given in words for part in given.split(",")):
        for one in groups.get(word, [word]):
            names = () if one == NOTHING else tuple(one.split("+"))
            if unknown := [name for name in names if name not in kinds]:
                raise Refused(
                    "study", f"unknown effect {unknown[0]!r}", f"valid: {', '.join([*groups, NOTHING, *kinds])}"
                )
            # in the generator's order, so that one set has one name
            out.append(tuple(kind for kind in kinds if kind in names))
    return tuple(dict.fromkeys(out))
