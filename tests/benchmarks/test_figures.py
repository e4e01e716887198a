"""Figures come from records of real runs: what is imported, what is counted, and what is written into a page."""

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.figures import benchmark_record, study_record
from benchmarks.figures.benchmark_figures import benchmark_figures
from benchmarks.figures.pages import UnknownFigure, filled
from benchmarks.figures.rate import Rate
from benchmarks.figures.study_figures import study_figures

EFFECT = "tip_payload"


def result(effect: str, seed: int, verdict: str, code: str = "new", manner: str = "rich") -> dict[str, Any]:
    """A case's record: an effect that was hidden, or none, and a diagnosis that names it where the verdict is `cause`."""
    hidden = [] if effect == "none" else [{"effect": effect, "where": "all", "parameters": {"mass": 0.1}}]
    parameters = [{"name": "m", "index": None, "value": 0.104, "sigma": 0.002}]
    causes = [{"effect": effect, "where": "all", "indistinguishable_from": [], "parameters": parameters}]
    return {
        "name": f"{effect}-{seed}-{manner}-size1-noise0.1-60+60s",
        "case": {"size": 1.0, "manner": manner},
        "code": code,
        "truth": {"hidden": hidden, "k": [1.0, 1.0, 1.0, 1.0]},
        "diagnosis": {"verdict": verdict, "causes": causes if verdict == "cause" else [], "gains": []},
    }


def written(folder: Path, *results: dict[str, Any]) -> Path:
    """A folder of cases."""
    folder.mkdir()
    for one in results:
        (folder / f"{one['name']}.json").write_text(json.dumps(one))
    return folder


@pytest.fixture
def cases(tmp_path: Path) -> Path:
    """Of six arms three times right, once missed; once nothing hidden; once in slow motion."""
    return written(
        tmp_path / "cases",
        *(result(EFFECT, seed, "cause") for seed in (1, 2, 3)),
        result(EFFECT, 4, "unknown"),
        result("none", 5, "consistent"),
        result(EFFECT, 6, "cause", manner="slow"),
    )


def test_rates_are_counted_with_exact_intervals(cases: Path) -> None:
    figures = study_figures(study_record.imported([cases]), {})
    assert figures["study.named"] == "3 of 4"
    assert figures["study.quiet"] == "1 of 1"
    assert figures["study.unknown"] == "none run yet"
    assert figures["study.arms"] == "5"
    assert f"- {EFFECT.replace('_', ' ')}" not in figures["study.missed"]
    assert f"{EFFECT}, arm 4: unknown" in figures["study.missed"]
    assert "| slow | 60 + 60 | 1 of 1 |" in figures["study.other"]
    # Clopper and Pearson 1934, by the quantiles of the beta distribution
    assert Rate(3, 4).interval_percent == pytest.approx((19.412, 99.369), abs=1e-3)
    assert Rate(0, 47).interval == "0 to 7.5 %"


def test_seeds_that_something_was_set_on_are_counted_nowhere(cases: Path) -> None:
    figures = study_figures(study_record.imported([cases]), {4: "a threshold", 6: "a delay", 99: "not run"})
    assert figures["study.named"] == "3 of 3"
    assert figures["study.arms"] == "4"
    assert figures["study.other"].strip() == "None yet."
    assert figures["study.left_out"].strip().splitlines() == ["- Arm 4: a threshold", "- Arm 6: a delay"]


def test_a_record_comes_back_as_it_was_imported(cases: Path, tmp_path: Path) -> None:
    imported = study_record.imported([cases])
    study_record.write_record(imported, tmp_path / "study_record.json")
    assert study_record.read_record(tmp_path / "study_record.json") == imported


def test_a_study_json_and_its_cases_are_the_same(cases: Path, tmp_path: Path) -> None:
    """A study.json holds the scores of its cases under one digest of the sources."""
    imported = study_record.imported([cases])
    study = {"settings": {"code": "new"}, "scores": [case.scored.as_json() for case in imported]}
    (tmp_path / "study.json").write_text(json.dumps(study))
    assert study_record.imported([tmp_path / "study.json"]) == imported
    assert study_record.imported([tmp_path]) == imported


def test_of_a_case_that_was_run_twice_the_last_counts(cases: Path, tmp_path: Path) -> None:
    again = written(tmp_path / "again", result(EFFECT, 4, "cause", code="newer"))
    both = study_record.imported([cases, again])
    assert study_figures(both, {})["study.named"] == "4 of 4"
    assert "- Seeds 4: sources newer." in study_figures(both, {})["study.made_from"]


def test_a_folder_without_cases_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no case"):
        study_record.imported([tmp_path])


def test_topics_that_were_measured_anew_replace_the_old_ones(tmp_path: Path) -> None:
    record = benchmark_record.read_record()
    claim = {"what": "frame times that are wrong, %", "on": "frames", "ours": 0.5, "peer": None, "limit": None}
    made_by = {"machine": record["clock"]["machine"] | {"processor": "another"}}
    topic = {"date": "2030-01-02T03:04", "commit": "abc", "made_by": made_by, "table": {"claims": [claim]}}
    (tmp_path / "benchmarks.json").write_text(json.dumps({"topics": {"lost_frames": topic}}))
    imported = benchmark_record.imported(tmp_path, record)
    assert list(imported) == list(record)
    figures = benchmark_figures(imported)
    assert figures["lost_frames.wrong_percent"] == "0.5 %"
    assert figures["clock.offset_ms"] == benchmark_figures(record)["clock.offset_ms"]
    assert "- lost_frames: 2030-01-02, commit abc, another, 2 cores" in figures["benchmarks.made_by"]


def test_a_page_is_filled_and_the_rest_of_it_stays() -> None:
    page = "Named <!--figure a.b-->1 of 2<!--/--> times.\n\n<!--figure table-->\n| old |\n<!--/-->\nEnd.\n"
    once = filled(page, {"a.b": "3 of 4", "table": "\n| new |\n"})
    assert once == "Named <!--figure a.b-->3 of 4<!--/--> times.\n\n<!--figure table-->\n| new |\n<!--/-->\nEnd.\n"
    assert filled(once, {"a.b": "3 of 4", "table": "\n| new |\n"}) == once


def test_an_unknown_figure_is_named() -> None:
    with pytest.raises(UnknownFigure, match=r"no figure a\.c; there are a\.b"):
        filled("<!--figure a.c--><!--/-->", {"a.b": ""})
