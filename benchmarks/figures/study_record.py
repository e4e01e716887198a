"""The record of study runs, benchmarks/record/study.json: one scored case a line, with what it was made by."""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from xneck.study.score import EffectScore, ParameterScore, Score, score_case

RECORD = Path(__file__).parents[1] / "record/study.json"

_NAME = re.compile(
    r"(?P<what>[a-z_+]+)-(?P<seed>\d+)-[a-z_]+-size[^-]+(-\d+)?-noise(?P<noise>.+)-(?P<fitted>[^-+]+)\+(?P<held_out>[^-+]+)s"
)
"""of a case, as `Case.name` makes it"""
_DIGITS = 5
"""of the numbers that are kept"""


@dataclass(frozen=True)
class ScoredCase:
    """A case of a study, and how its diagnosis was scored."""

    seed: int
    seconds: tuple[float, float]
    """length of the recording that was fitted, and of the one that was held out"""
    noise_deg: float
    code: str
    """digest of the sources that ran it"""
    scored: Score


def imported(paths: Iterable[Path]) -> tuple[ScoredCase, ...]:
    """Cases of study.json files, of folders that hold one, and of folders with a file for each case.

    Of cases with the same name the last counts. Raises ValueError where a path holds no case.
    """
    cases: dict[str, ScoredCase] = {}
    for path in paths:
        found = _of_path(path)
        if not found:
            raise ValueError(f"{path}: holds no case of a study; give a study.json, its folder, or a folder of cases")
        cases |= {case.scored.name: case for case in found}
    return tuple(cases.values())


def _of_path(path: Path) -> list[ScoredCase]:
    if path.is_file():
        return _of_study(json.loads(path.read_text(encoding="utf-8")))
    if (path / "study.json").is_file():
        return _of_path(path / "study.json")
    results = (json.loads(file.read_text(encoding="utf-8")) for file in sorted(path.glob("*.json")))
    return [_case(score_case(result).as_json(), result["code"]) for result in results]


def _of_study(study: Mapping[str, Any]) -> list[ScoredCase]:
    return [_case(scored, study["settings"]["code"]) for scored in study["scores"]]


def _case(scored: Mapping[str, Any], code: str) -> ScoredCase:
    """From a score as `xneck study --json` writes it."""
    parts = _NAME.fullmatch(scored["name"])
    if parts is None:
        raise ValueError(f"{scored['name']}: is not the name of a case")
    return ScoredCase(
        seed=int(parts["seed"]),
        seconds=(float(parts["fitted"]), float(parts["held_out"])),
        noise_deg=float(parts["noise"]),
        code=code,
        scored=_score(scored),
    )


def _score(scored: Mapping[str, Any]) -> Score:
    values = _own(Score, scored)
    values["sightings"] = tuple(_effect_score(sighting) for sighting in scored["sightings"])
    values["false"] = tuple(scored["false"])
    return Score(**values)


def _effect_score(sighting: Mapping[str, Any]) -> EffectScore:
    values = _own(EffectScore, sighting)
    values["numbers"] = tuple(ParameterScore(**_own(ParameterScore, number)) for number in sighting["numbers"])
    return EffectScore(**values)


def _own(record: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """The values that are fields of the record: what is derived from them is left out."""
    return {field.name: values[field.name] for field in fields(record)}


def write_record(cases: Sequence[ScoredCase], path: Path = RECORD) -> None:
    """One case a line, whole or not at all."""
    lines = [json.dumps({"code": case.code} | _rounded(case.scored.as_json())) for case in cases]
    path.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


def read_record(path: Path = RECORD) -> tuple[ScoredCase, ...]:
    """All cases of the record."""
    return tuple(_case(line, line["code"]) for line in json.loads(path.read_text(encoding="utf-8")))


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, dict):
        return {key: _rounded(one) for key, one in value.items()}
    return [_rounded(one) for one in value] if isinstance(value, list | tuple) else value
