"""What a study comes to: the scores of its cases and their tables, as text and as the files study.md and study.json."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from xneck.recording.result_files import STUDY_RECORD, STUDY_TABLES
from xneck.study.count_table import CountTable
from xneck.study.score import Score, score_case
from xneck.study.summary import summary_tables
from xneck_foundation.json_text import json_text
from xneck_foundation.whole_file import write_text


@dataclass(frozen=True)
class StudyResult:
    """Scores and tables of the cases that came to an end, with the study's settings."""

    settings: Mapping[str, Any]
    scores: tuple[Score, ...]
    tables: tuple[CountTable, ...]
    failed: Mapping[str, str]
    """reason by name of case"""
    done_before: int
    """cases that an earlier run had finished"""

    @classmethod
    def of(
        cls,
        records: Sequence[Mapping[str, Any]],
        kinds: Sequence[str],
        settings: Mapping[str, Any],
        failed: Mapping[str, str],
        done_before: int,
    ) -> "StudyResult":
        """The result of the cases' `records`; the tables list effects in the order of `kinds`."""
        scores = tuple(score_case(record) for record in records)
        return cls(settings, scores, summary_tables(scores, kinds), failed, done_before)

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON, as study.json has it."""
        return {
            "settings": self.settings,
            "cases": len(self.scores),
            "failed": self.failed,
            "tables": [table.as_json() for table in self.tables],
            "scores": [score.as_json() for score in self.scores],
        }

    def text(self) -> str:
        """The tables, and the count of cases, for a terminal."""
        return "\n\n".join([*(table.text() for table in self.tables), self._count()])

    def write_files(self, folder: Path) -> None:
        """Writes study.md and study.json."""
        settings = ", ".join(f"{key} {value}" for key, value in self.settings.items())
        parts = [f"# {self._count()}", settings, *(table.markdown() for table in self.tables)]
        if self.failed:
            parts.append("## Failed\n\n" + "\n".join(f"- {name} failed: {why}" for name, why in self.failed.items()))
        write_text(folder / STUDY_TABLES, "\n\n".join(parts) + "\n")
        write_text(folder / STUDY_RECORD, json_text(self.as_json()))

    def _count(self) -> str:
        return f"{len(self.scores)} cases, {self.done_before} of them done before; {len(self.failed)} failed"
