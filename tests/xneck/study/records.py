"""Records of cases made by hand: hidden effects, named causes, and the score of both."""

from typing import Any

from xneck.study.score import Score, score_case

TRUTH: dict[str, Any] = {"k": [10e3, 9e3, 8e3, 5e3]}
DRUM = {"effect": "drum_radius", "where": "motor 3", "parameters": {"factor": 1.04}}
TILT = {"effect": "base_tilt", "where": "all", "parameters": {"tilt": 0.05}}
COGGING = {"effect": "cogging", "where": "all", "parameters": {"force1": 2.0}}


def cause(
    effect: str, where: str = "all", *parameters: tuple[str, int | None, float, float], alike: Any = ()
) -> dict[str, Any]:
    numbers = [{"name": n, "index": i, "value": v, "sigma": s} for n, i, v, s in parameters]
    return {"effect": effect, "where": where, "parameters": numbers, "indistinguishable_from": list(alike)}


def scored(
    hidden: list[dict[str, Any]], verdict: str, *causes: dict[str, Any], size: float = 1.0, name: str = "a"
) -> Score:
    gains = [
        {"unit": "N", "before": 4.0, "after": 1.5, "noise_floor": 1.0},
        {"unit": "N m", "before": 6.0, "after": 2.4, "noise_floor": 2.0},
        {"unit": "rad", "before": 9.0, "after": 9.0, "noise_floor": 1.0},  # simulated angles are no equation
    ]
    return score_case(
        {
            "name": name,
            "case": {"manner": "rich", "size": size},
            "truth": TRUTH | {"hidden": hidden},
            "diagnosis": {"verdict": verdict, "causes": list(causes), "gains": gains},
        }
    )


FOUND = cause("drum_radius", "motor 3", ("rd", 3, 0.043, 0.002))
