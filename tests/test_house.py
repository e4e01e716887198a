"""The rooms of the house: imports go down only and in no circle, and no room outgrows the others."""

import pytest

from benchmarks.import_graph import House, circles, house

MAX_SHARE = 0.25
"""of all lines, in one room"""


@pytest.fixture(scope="module")
def built() -> House:
    return house()


def test_no_modules_import_each_other(built: House) -> None:
    assert built.circles == ()


def test_no_import_goes_up(built: House) -> None:
    assert built.upward == ()


def test_no_room_holds_more_than_a_quarter_of_the_lines(built: House) -> None:
    assert {room.name: built.share(room) for room in built.rooms if built.share(room) > MAX_SHARE} == {}


def test_a_circle_is_noticed() -> None:
    imports = {"a": {"b"}, "b": {"c"}, "c": {"a", "d"}, "d": set()}
    assert circles(imports) == (("a", "b", "c"),)
    assert circles(imports | {"c": {"d"}}) == ()
