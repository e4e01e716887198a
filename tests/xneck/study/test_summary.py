"""The tables of a study count what the scores say."""

from dataclasses import replace

from samples.generator.hidden.experiment import CATALOGUE
from tests.xneck.study.records import COGGING, DRUM, FOUND, TILT, cause, scored
from xneck.study.summary import summary_tables


def test_tables_count() -> None:
    scores = [
        scored([], "consistent"),
        scored([], "cause", FOUND),
        scored([DRUM], "cause", FOUND),
        scored([DRUM], "ambiguous", cause("marker_offset", alike=["drum_radius"])),
        scored([COGGING], "unknown"),
        scored([TILT, DRUM], "cause", FOUND),
    ]
    made = {table.title: table for table in summary_tables(scores, [*CATALOGUE, "cogging"])}
    confusion, found, alarms, pairs = made.values()
    assert [row[0].split()[-1] for row in confusion.rows] == ["none", "drum_radius", "cogging"]
    records = confusion.as_json()["rows"]
    drum, marker = (str([*CATALOGUE].index(name) + 1) for name in ("drum_radius", "marker_offset"))
    assert (records[0]["consistent"], records[0][drum]) == ("1", "1")
    assert (records[1][drum], records[1][marker], records[1]["consistent"]) == ("1", "1", ".")
    assert records[2]["unknown"] == "1"
    (row,) = found.as_json()["rows"]
    assert (row["cases"], row["named first"], row["in the set"], row["alone"]) == ("2", "1/2", "2/2", "1/2")
    assert (row["right place"], row["within 3 sigma"], row["rms z"]) == ("1/1", "1/1", "1.5")
    assert [(row["hidden"], row["a cause named"], row["unknown"]) for row in alarms.as_json()["rows"]] == [
        ("none", "1/2", "0/2"),
        ("cogging", "0/1", "1/1"),
    ]
    assert "All named: 0/1" in pairs.note
    assert "one or more named: 1/1" in pairs.note


def test_detection_is_counted_by_size_where_sizes_differ() -> None:
    said = {0.1: "consistent", 0.2: "consistent", 0.3: "unknown", 0.4: "consistent", 0.5: "unknown", 0.6: "unknown"}
    scores = [replace(scored([DRUM], verdict), size=size) for size, verdict in said.items()]
    scores += [replace(scored([DRUM], "cause", FOUND), size=size) for size in (0.7, 0.8)]
    made = {table.title: table for table in summary_tables(scores, [*CATALOGUE])}
    (row,) = made["Detection against size"].rows
    assert row == ("drum_radius", "0 0 2", "0 1 2", "0 2 2", "2 2 2")
    assert "Detection against size" not in {table.title for table in summary_tables(scores[-1:], [*CATALOGUE])}
