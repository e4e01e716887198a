"""Configuration files mean what a person reads in them, and say all that is wrong at once."""

import re
import tracemalloc
from pathlib import Path
from typing import Annotated

import pytest
from pydantic import Field

from xneck_foundation.errors import Refused
from xneck_foundation.strict_yaml import Strict, parse_yaml, read_yaml

MAX_HELD_BYTES = 2_000_000
"""of a bomb: 50,000 values, the fewest that are refused, take more once they are built"""


class Part(Strict):
    mass: Annotated[float, Field(gt=0)]
    at: tuple[float, float] = (0.0, 0.0)


class Whole(Strict):
    name: str
    parts: tuple[Part, ...]


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 0.001), ("2.5E+6", 2.5e6), (".5", 0.5), ("12", 12), ("-0", 0), ("true", True), ("~", None)],
)
def test_numbers_and_booleans_are_yaml_1_2s(text: str, value: object) -> None:
    assert parse_yaml(f"a: {text}", "x")["a"] == value


@pytest.mark.parametrize("text", ["012", "1:30", "on", "yes", "1_000", "0x1F"])
def test_what_yaml_1_1_turned_into_surprises_stays_text(text: str) -> None:
    assert parse_yaml(f"a: {text}", "x")["a"] == text


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a: 1\na: 2", "stands twice"),
        ("a: *x", "undefined alias"),
        ("a: &x [*x]", "within what it stands for"),
        ("a: &x {<<: *x}", "within what it stands for"),
        ("a: {<<: [1]}", "takes over one group of keys"),
        ("a: &x {b: 1}\nc: {<<: *x, <<: *x}", "stands twice"),
        ("a: &x {b: 1}\nc: {<<: *x, d: 1, d: 2}", "stands twice"),
        ("? [1]\n: 2", "not text"),
        ("a: [1", "line"),
        ("a:\n\tb: 1", "line 2: .*; indent with spaces, not with tabs"),
        ("1: 2", "not text"),
        ("a: !!python/object:os.system x", "tags such as"),
        ("a: !!bool maybe", "tags such as"),
        ("a: &x 1\nb: &x 2", "duplicate anchor"),
    ],
)
def test_ambiguous_or_dangerous_yaml_is_refused_with_its_line(text: str, word: str) -> None:
    with pytest.raises(Refused, match=word):
        parse_yaml(text, "file.yaml")


def test_what_is_alike_is_said_once() -> None:
    """An alias stands for a value, a merge key takes keys over; those beside it go before, wherever they stand."""
    text = "m:\n  - &a {R: 1, b: [1, 2]}\n  - *a\n  - {R: 3, <<: *a}\n  - &b {<<: *a, c: 4}\n  - {<<: *b, b: 5}"
    a = {"R": 1, "b": [1, 2]}
    assert parse_yaml(text, "x") == {"m": [a, a, a | {"R": 3}, a | {"c": 4}, a | {"c": 4, "b": 5}]}


def chain(first: str, next_one: str, count: int) -> str:
    """Lines of which each is made of the one before."""
    lines = [f"a0: &a0 {first}", *(f"a{i}: &a{i} {next_one.replace('*', f'*a{i - 1}')}" for i in range(1, count))]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (chain("[x, x, x, x, x, x, x, x, x, x]", "[*, *, *, *, *, *, *, *, *, *]", 30), "keys and values"),
        (chain("{k: 1, l: 2}", "{<<: *, x: {<<: *}, y: *}", 12), "keys and values"),
        ("a: &a " + "x" * 300_000 + "\nb: [*a, *a, *a]", "characters with aliases written out"),
        (chain("[1]", "[*]", 30), "nested more than"),
        ("[" * 10 + "&a [[[[[[[[1]]]]]]]], *a" + "]" * 10, None),
        ("[" * 15 + "&a [[[[1]]]], [[*a]]" + "]" * 15, "nested more than"),
    ],
    ids=["values", "merged values", "characters", "depth", "as deep as written out", "deeper by an alias"],
)
def test_bombs_of_aliases_are_refused_before_they_are_built(text: str, word: str | None) -> None:
    """Each is a few kB, and some would be larger than any memory: what is held on the way stays that small."""
    tracemalloc.start()
    try:
        if word is None:
            parse_yaml(text, "x")
        else:
            with pytest.raises(Refused, match=word):
                parse_yaml(text, "x")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < MAX_HELD_BYTES


def test_all_faults_of_a_file_are_named_with_their_paths(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text("name: 3\nparts:\n  - {mass: -1}\n  - {mass: 1, colour: red}\n  - {mass: '1'}\n  - {mass: .nan}\n")
    with pytest.raises(Refused) as caught:
        read_yaml(file, Whole)
    text = str(caught.value)
    for place in ("name:", "parts[0].mass", "parts[1].colour: unknown key", "parts[2].mass", "parts[3].mass"):
        assert place in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name: a\nprats: []\n", "prats: unknown key, did you mean parts?"),
        ("name: a\nparts: [{mas: 1}]\n", "parts[0].mas: unknown key, did you mean mass?"),
        ("name: a\nparts: [{mass: 1, colour: red}]\n", "parts[0].colour: unknown key, valid: mass, at"),
        ("name: a\nparts: [{mass: 1, Mass: 2}]\n", "parts[0].Mass: unknown key, mass is there already, leave one out"),
    ],
)
def test_a_misspelt_key_is_one_fault(text: str, says: str, tmp_path: Path) -> None:
    """What was likely meant is not said to be missing besides; what is there already is said to be."""
    file = tmp_path / "w.yaml"
    file.write_text(text)
    with pytest.raises(Refused) as caught:
        read_yaml(file, Whole)
    assert str(caught.value) == f"{file}: {says}"


def test_two_keys_are_not_taken_for_the_same_one(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text("name: a\nparts: [{mas: 1, masss: 2}]\n")
    with pytest.raises(Refused, match=r"mas: unknown key, did you mean mass\?; .*masss: unknown key, valid: mass, at$"):
        read_yaml(file, Whole)


def test_many_faults_are_counted(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text("name: a\nparts: [" + "".join(f"{{mass: -{i}}}, " for i in range(40)) + "]\n")
    with pytest.raises(Refused) as caught:
        read_yaml(file, Whole)
    found = re.search(r"(parts.*); \.\.\. and (\d+) more$", str(caught.value))
    assert found is not None
    assert found[1].count("parts[") + int(found[2]) == 40
    assert len(str(caught.value)) < 500


def test_a_whole_file_reads_as_written(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text("name: arm\nparts: [{mass: 1, at: [0, 1e-3]}]\n")
    assert read_yaml(file, Whole) == Whole(name="arm", parts=(Part(mass=1.0, at=(0.0, 0.001)),))


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"just words", b"- 1\n- 2"])
def test_other_files_are_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "w.yaml"
    file.write_bytes(content)
    with pytest.raises(Refused):
        read_yaml(file, Whole)
    with pytest.raises(Refused, match="does not exist"):
        read_yaml(tmp_path / "absent.yaml", Whole)


def test_a_file_in_another_encoding_is_told_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "neck.yaml").write_bytes("# Länge\na: 1\n".encode("latin-1"))
    with pytest.raises(Refused, match=r"not UTF-8 text.; save it as UTF-8"):
        read_yaml(tmp_path / "neck.yaml", Whole)


def test_a_video_or_a_table_in_place_of_yaml_is_called_by_its_name(tmp_path: Path) -> None:
    """ "Save it as UTF-8" was said of a video that was named in place of its folder."""
    for content, name in ((b"\0\0\0\x18ftypisom\xff", "a video"), (b"PAR1\xff", "a Parquet file")):
        (tmp_path / "it").write_bytes(content)
        with pytest.raises(Refused, match=f"is {name}, and no text; name the file that is meant"):
            read_yaml(tmp_path / "it", Whole)
    (tmp_path / "it").write_bytes("a: 1".encode("utf-16"))
    with pytest.raises(Refused, match=r"not UTF-8 text.; save it as UTF-8"):
        read_yaml(tmp_path / "it", Whole)
