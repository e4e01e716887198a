"""Fasquelle's tables 1 and 2 of an identification, as text and as JSON."""

from typing import Any

from identification.fasquelle.method import FasquelleFit, FasquelleIdentification
from mechanism.elasticity import ELASTIC_MODELS, ElasticModel
from xneck_foundation.one_line import indexed
from xneck_foundation.parameter import Parameter


def as_json(identification: FasquelleIdentification, model: ElasticModel = 1) -> dict[str, Any]:
    """Fasquelle's record: parameters of the chosen elastic model, and all the tables."""
    fits = {"dry": identification.dry_only, "dry_and_viscous": identification.dry_and_viscous}
    fits |= {f"model_{m}": identification.elastic[m] for m in ELASTIC_MODELS}
    return {
        "parameters": [p.as_json() for p in identification.elastic[model].parameters],
        "fit": {
            "elastic_model": model,
            "samples": len(identification.tension_from_force),
            "mean_tension_error_N": {f"model_{m}": identification.mean_error(m) for m in ELASTIC_MODELS},
            "tables": {
                name: {
                    "title": fit.title,
                    "condition": fit.estimate.condition,
                    "rank": len(fit.estimate.base),
                    "base_parameters": [
                        indexed(fit.parameters[i].name, fit.parameters[i].index) for i in fit.estimate.base
                    ],
                    "parameters": [p.as_json() for p in fit.parameters],
                }
                for name, fit in fits.items()
            },
        },
    }


def as_text(identification: FasquelleIdentification) -> str:
    """Both tables with a sentence before them, a parameter a row and a model a column."""
    one = _table("Table 1: friction, from the arm equations", [identification.dry_and_viscous, identification.dry_only])
    two = _table("Table 2: friction and elasticity", [identification.elastic[m] for m in ELASTIC_MODELS])
    errors = ", ".join(f"model {m} {identification.mean_error(m):.2f} N" for m in ELASTIC_MODELS)
    said = (
        "For comparison, the same recordings by the method of Fasquelle's report, whose numbers may be biased; in brackets "
        "its relative sigmas."
    )
    return f"{said}\n\n{one}\n\n{two}\nmean tension reconstruction error: {errors}"


def table_rows(fits: list[FasquelleFit]) -> list[tuple[str, str, list[Parameter | None]]]:
    """Rows of a table of several fits: label, unit, and the parameter of each fit (None where it has none)."""
    keys: dict[tuple[str, int | None], str] = {}
    for fit in fits:
        for p in fit.parameters:
            keys.setdefault((p.name, p.index), p.unit)
    out = []
    for (name, index), unit in keys.items():
        label = indexed(name, index)
        parameters = [next((p for p in fit.parameters if (p.name, p.index) == (name, index)), None) for fit in fits]
        out.append((label, unit, parameters))
    return sorted(out, key=lambda row: (["fs", "fv", "k", "E", "ca", "c"].index(row[0].split("(")[0]), row[0]))


def _table(title: str, fits: list[FasquelleFit]) -> str:
    lines = [title, f"{'':16}" + "".join(f"{fit.title:>26}" for fit in fits)]
    for label, unit, parameters in table_rows(fits):
        cells = "".join(f"{_cell(p):>26}" for p in parameters)
        lines.append(f"{label:7}{unit:9}{cells}")
    bases = [f"{len(fit.estimate.base)} of {len(fit.parameters)}, {fit.estimate.condition:.3g}" for fit in fits]
    lines.append(f"{'base, condition':16}" + "".join(f"{cell:>26}" for cell in bases))
    lines.append("* not identified: relative sigma above 10 %")
    return "\n".join(lines)


def _cell(p: Parameter | None) -> str:
    if p is None:
        return "-"
    return f"{p.value:.5g}{' ' if p.identified else '*'}({p.relative_sigma_percent:6.2f} %)"
