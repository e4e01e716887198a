"""The closed forms of cable lengths are those of a taut string over wheels, and Z is their slope.

The string is drawn by the sample generator's own geometry (tangents of circles and angles wound between them), which
shares no formula with the package.
"""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from mechanism.arm import Arm, arm_of
from mechanism.cable_lengths import Z, Z_dot, lengths, lengths_without_pulleys
from mechanism.description import Neck, read_neck
from mechanism.geometry import check_angles
from samples.generator.linkage import solve
from samples.generator.routes import WORDS, cable_table, piece
from samples.generator.routes import lengths as string_lengths
from samples.generator.taut_string import Wheel, tighten
from xneck_foundation.errors import Refused

EXACT = 1e-12
"""m: some thousand roundings of lengths up to 10 m"""
SAMPLE = Path("samples/recording/neck.yaml")
claims = settings(derandomize=True, deadline=None, max_examples=150)

_THROUGH = {"right": ("right_through", "strut"), "left": ("left_through", "strut_mirrored")}


@st.composite
def necks(draw: st.DrawFn, mechanisms: int | None = None) -> dict[str, Any]:
    """Arms of 1..4 unlike mechanisms whose wheels fit at every angle, with a cable of every way to end."""
    n = mechanisms or draw(st.integers(1, 4))
    parts = []
    for _ in range(n):
        L = draw(st.floats(0.02, 1.0))
        b = L * draw(st.floats(0.1, 0.95))
        r = min(L - b, b / 2) * draw(st.floats(0.05, 0.95))
        parts.append({"L": L, "b": b, "r": r})
    cables = []
    for side in ("right", "left"):
        for end in (side, *_THROUGH[side]):
            route = [draw(st.sampled_from(_THROUGH[side])) for _ in range(n - 1)] + [end]
            cables.append({"route": route, "length": 1.0, "section": 1e-6})
    body = {"mass": 0.03, "inertia": 1e-5}
    rest = {"diagonal": body, "top": body, "springs": {"stiffness": 100.0, "free_length": 0.05}}
    motors = [{"R": 25, "rd": 0.01, "Ia": 5e-6, "counts": 2048}] * len(cables)
    return {"xneck": 1, "mechanisms": [p | rest for p in parts], "cables": cables, "motors": motors}


def arm_from(neck: dict[str, Any]) -> Arm:
    return arm_of(Neck.model_validate_json(json.dumps(neck)))


def angles(seed: int, n: int, count: int = 20, reach: float = 2.8) -> np.ndarray:
    """Shape (count, n), rad."""
    return np.random.default_rng(seed).uniform(-reach, reach, (count, n))


@claims
@given(necks(mechanisms=1), st.integers(0, 10**6))
def test_every_route_word_is_a_taut_string(neck: dict[str, Any], seed: int) -> None:
    """(19), (20), (25), (30) with acos, and their mirrors: the string from the entry wheel's lowest point on."""
    m = neck["mechanisms"][0]
    neck["cables"] = [neck["cables"][0] | {"route": [word]} for word in WORDS]
    arm = arm_from(neck)
    alpha = angles(seed, 1)
    for j, word in enumerate(WORDS):
        string = piece(word, alpha[:, 0], m["L"], m["b"], m["r"])
        np.testing.assert_allclose(lengths(arm, alpha)[:, j], string.length, rtol=0, atol=EXACT, err_msg=word)
        np.testing.assert_allclose(-Z(arm, alpha)[:, 0, j], string.slope, rtol=0, atol=EXACT, err_msg=word)


@claims
@given(necks(), st.integers(0, 10**6))
def test_whole_cables_are_sums_of_their_pieces(neck: dict[str, Any], seed: int) -> None:
    """Any number of unlike mechanisms and any route: the arm's cables have the string's lengths."""
    alpha = angles(seed, len(neck["mechanisms"]))
    np.testing.assert_allclose(lengths(arm_from(neck), alpha), string_lengths(neck, alpha), rtol=0, atol=EXACT)


def test_one_string_over_all_wheels_winds_a_full_turn_on_shared_ones() -> None:
    """Cable 4 drawn in one go around the left side's wheels: a full turn, less the mean angle, on each shared wheel.

    Cable 3 in one go along two struts: there the string stays on the wheels without a turn.
    """
    arm = arm_of(read_neck(SAMPLE))
    alpha = angles(3, 3, count=50, reach=1.2)
    bars = solve(alpha, arm.L, arm.b)
    r = float(arm.r[0])
    left = [Wheel(bars.left[:, 0], r, -1, np.pi / 2)]
    left += [Wheel(bars.left[:, i], r, -1, 2 * np.pi) for i in (1, 2)]
    cable_4 = tighten([*left, Wheel(bars.left[:, 3], 0.0, 0, 0.0)], np.array(-1 + 0j), None)
    np.testing.assert_allclose(lengths(arm, alpha)[:, 3], cable_4.length, rtol=0, atol=EXACT)
    np.testing.assert_allclose(cable_4.wound[:, 1], 2 * np.pi - (alpha[:, 0] + alpha[:, 1]) / 2, rtol=0, atol=1e-12)

    strut = [Wheel(bars.right[:, 0], r, +1, 2.0)]
    for i in (1, 2):
        strut += [Wheel(bars.left[:, i], r, -1, 2.5), Wheel(bars.right[:, i], r, +1, 2.0)]
    cable_3 = tighten([*strut, Wheel(bars.right[:, 3], 0.0, 0, 0.0)], np.array(1 + 0j), None)
    np.testing.assert_allclose(lengths(arm, alpha)[:, 2], cable_3.length, rtol=0, atol=EXACT)
    assert cable_3.wound[:, :-1].min() > 0, "the string lies on every wheel"
    assert np.ptp(cable_3.spans[:, :4], axis=0).max() < EXACT, "its straight parts along bars keep their lengths"


@claims
@given(necks(mechanisms=1), st.integers(0, 10**6))
def test_mirror_images(neck: dict[str, Any], seed: int) -> None:
    """Turning the arm over swaps the sides and the sign of alpha; a strut's length is even in alpha."""
    neck["cables"] = [neck["cables"][0] | {"route": [word]} for word in WORDS]
    arm = arm_from(neck)
    alpha = angles(seed, 1)
    here, there = (dict(zip(WORDS, lengths(arm, a).T, strict=True)) for a in (alpha, -alpha))
    for one, other in (("right", "left"), ("right_through", "left_through"), ("strut", "strut_mirrored")):
        np.testing.assert_allclose(here[one], there[other], rtol=0, atol=EXACT)
    np.testing.assert_allclose(here["strut"], there["strut"], rtol=0, atol=EXACT)


@claims
@given(necks(), st.integers(0, 10**6))
def test_Z_is_minus_the_slope_of_the_lengths(neck: dict[str, Any], seed: int) -> None:
    """(3) by central differences, extrapolated to O(h^4).

    Rounding: 1e-15 m / h; truncation: h^4 times a fifth derivative, which nears (b / room) times the length near r = side.
    """
    arm = arm_from(neck)
    alpha = angles(seed, arm.N, count=5, reach=1.5)
    h = 1e-3

    def slope(step: float) -> np.ndarray:
        moves = step * np.eye(arm.N)[:, None, :]
        return (lengths(arm, alpha + moves) - lengths(arm, alpha - moves)) / (2 * step)

    found = np.moveaxis((4 * slope(h / 2) - slope(h)) / 3, 0, 1)
    np.testing.assert_allclose(Z(arm, alpha), -found, rtol=0, atol=1e-9 * arm.L.max())


@claims
@given(necks(), st.integers(0, 10**6))
def test_Z_dot_is_the_rate_of_Z(neck: dict[str, Any], seed: int) -> None:
    """Z along a straight path through alpha, by central differences extrapolated to O(h^4)."""
    arm = arm_from(neck)
    alpha, alpha_d = angles(seed, arm.N, count=5, reach=1.5), angles(seed + 1, arm.N, count=5, reach=3.0)
    h = 3e-4

    def rate(step: float) -> np.ndarray:
        return (Z(arm, alpha + step * alpha_d) - Z(arm, alpha - step * alpha_d)) / (2 * step)

    found = (4 * rate(h / 2) - rate(h)) / 3
    np.testing.assert_allclose(Z_dot(arm, alpha, alpha_d), found, rtol=0, atol=1e-8 * arm.L.max())


@claims
@given(necks(), st.integers(0, 10**6))
def test_wheels_without_radius_leave_bars_and_sides(neck: dict[str, Any], seed: int) -> None:
    """(7)-(10) are the case r = 0, and the bars and sides of the linkage."""
    arm = arm_from(neck)
    points = replace(arm, r=np.zeros(arm.N))
    alpha = angles(seed, arm.N)
    np.testing.assert_allclose(lengths(points, alpha), lengths_without_pulleys(arm, alpha), rtol=0, atol=EXACT)


def test_the_fast_table_is_the_string() -> None:
    """What the generator simulates with: l to rounding, its slope to 1e-12 m."""
    neck = yaml.safe_load(SAMPLE.read_text(encoding="utf-8"))
    arm, table = arm_of(read_neck(SAMPLE)), cable_table(neck)
    for alpha in angles(5, 3, count=200, reach=1.5):
        length, slope = table(alpha)
        np.testing.assert_allclose(length, lengths(arm, alpha), rtol=0, atol=1e-14)
        np.testing.assert_allclose(slope, -Z(arm, alpha), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("sizes", "says"),
    [
        ({"r": 0.026}, "b/2"),
        ({"L": 0.0505, "r": 0.008}, "too short"),
        ({"L": 0.05}, "cross"),
        ({"b": 50}, "mechanisms"),
    ],
)
def test_wheels_that_do_not_fit_are_refused(tmp_path: Path, sizes: dict[str, float], says: str) -> None:
    """b/2 > r, sides longer than r, crossing diagonals, metres: otherwise no string has these lengths."""
    neck = yaml.safe_load(SAMPLE.read_text(encoding="utf-8"))
    neck["mechanisms"][1] |= sizes
    (tmp_path / "neck.yaml").write_text(yaml.safe_dump(neck), encoding="utf-8")
    with pytest.raises(Refused, match=says) as refusal:
        read_neck(tmp_path / "neck.yaml")
    assert "mechanisms" in str(refusal.value)
    assert "1" in str(refusal.value)


def test_angles_that_leave_no_room_are_refused() -> None:
    """A wheel that fits in the straight pose may not fit in a bent one; half a turn is singular."""
    arm = replace(arm_of(read_neck(SAMPLE)), b=np.full(3, 0.085), r=np.full(3, 0.02))
    check_angles(arm, np.zeros(3))
    for bent in (1.8, -1.8):  # sides: 0.02 m reached at sin(|alpha|/2) = 0.69
        with pytest.raises(Refused, match="alpha2"):
            check_angles(arm, np.array([0.0, bent, 0.0]))
    with pytest.raises(Refused, match="singular"):
        check_angles(arm, np.array([0.0, 0.0, 3.2]))
    with pytest.raises(Refused, match="finite"):
        check_angles(arm, np.array([0.0, np.nan, 0.0]))
