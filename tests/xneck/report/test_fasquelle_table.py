"""Published values stand beside arms with as many cables only."""

from xneck.recording.recording_result import RecordingResult
from xneck.report import fasquelle_published
from xneck.report.fasquelle_table import fasquelle_table


def test_published_values_are_not_compared_with_another_arm(result: RecordingResult) -> None:
    fits = [result.fasquelle.dry_and_viscous, result.fasquelle.dry_only]
    assert len(fasquelle_table("", fits, fasquelle_published.TABLE_1, cables=4).rows[0][3]) == 2
    assert all(row[3] == () for row in fasquelle_table("", fits, fasquelle_published.TABLE_1, cables=3).rows)
