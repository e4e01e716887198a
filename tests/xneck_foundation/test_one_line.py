"""A refusal is one line that a person reads to its end and a terminal prints as it is."""

import json
import pickle
from pathlib import Path

import pytest

from xneck_foundation.errors import MAX_CHARACTERS, Refused, one_of
from xneck_foundation.json_text import json_text
from xneck_foundation.one_line import listed, printable, shortened
from xneck_foundation.spelling import likely_spelling, valid_words

HOSTILE = "a\x1b[31m\nb\r\x07\u202e\x9b1m\udcff\u2028c"


@pytest.mark.parametrize("part", ["where", "what", "do"])
def test_nothing_of_a_refusal_reaches_the_terminal_raw(part: str) -> None:
    line = str(Refused(**({"where": "file", "what": "is wrong", "do": "mend it"} | {part: HOSTILE})))
    assert line.isprintable()
    line.encode()  # a name that is no UTF-8 can be printed too
    assert r"a\x1b[31m" in line


def test_the_name_of_a_file_keeps_its_line_ends_as_escapes() -> None:
    assert str(Refused(Path("a\nb"), "two\n  lines")) == r"a\nb: two lines"


@pytest.mark.parametrize("where", ["x.yaml", "/folder" * 200 + "/neck.yaml"])
@pytest.mark.parametrize("what", ["is wrong", "w" * 5000])
@pytest.mark.parametrize("do", ["", "mend it", "d" * 5000])
def test_a_refusal_is_short_and_still_says_where(where: str, what: str, do: str) -> None:
    refusal = Refused(where, what, do)
    assert len(str(refusal)) <= MAX_CHARACTERS
    assert where.rpartition("/")[2] in str(refusal)
    assert what[:50] in str(refusal)
    assert do[:50] in str(refusal)
    assert (refusal.where, refusal.what, refusal.do) == (where, what, do)


def test_a_refusal_goes_from_process_to_process() -> None:
    back = pickle.loads(pickle.dumps(Refused(Path("x"), "is wrong", "mend it")))
    assert (back.where, back.what, back.do) == ("x", "is wrong", "mend it")


def test_what_is_left_out_of_a_list_is_counted() -> None:
    words = [f"word{k}" for k in range(30)]
    text = listed(words, limit=40)
    shown = text.split(", ")
    assert shown[:-1] == words[: len(shown) - 1]
    assert shown[-1] == f"... and {30 - len(shown) + 1} more"
    assert len(text) < 60
    assert listed(words[:3]) == "word0, word1, word2"
    assert listed([]) == ""


def test_both_ends_of_a_long_text_stay() -> None:
    assert shortened("abcdefghijklmnopqrst", 15) == "abcdef ... qrst"
    assert shortened("abc", 15) == "abc"


def test_what_prints_is_not_touched() -> None:
    assert printable("α₁ = 3°, naïve/モーター.csv") == "α₁ = 3°, naïve/モーター.csv"


@pytest.mark.parametrize(
    ("word", "meant"), [("stifness", "stiffness"), ("Route", "route"), ("THETA1", "theta1"), ("x" * 10**6, None), ("gear", None)]
)  # fmt: skip
def test_a_likely_spelling(word: str, meant: str | None) -> None:
    valid = ["stiffness", "free_length", "slack", "route", "theta1"]
    assert likely_spelling(word, valid) == meant
    assert valid_words(word, valid) == (f"did you mean {meant}?" if meant else f"valid: {', '.join(valid)}")


def test_an_unknown_word_is_refused_with_what_was_meant() -> None:
    with pytest.raises(Refused, match=r"unknown kind 'aprilgird'; did you mean aprilgrid\?$"):
        one_of("board.yaml", "aprilgird", ("charuco", "aprilgrid"), "kind")
    assert one_of("board.yaml", "charuco", ("charuco", "aprilgrid"), "kind") == "charuco"


def test_json_is_printable_and_reads_back() -> None:
    text = json_text({"file": HOSTILE, "α": [1.5, float("nan")]})
    assert all(line.isprintable() for line in text.splitlines())
    text.encode()
    assert json.loads(text) == {"file": HOSTILE, "α": [1.5, None]}
    assert "α" in text
