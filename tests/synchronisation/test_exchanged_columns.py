"""Columns in each other's places are named as what they are, whatever else they then seem to be."""

import re
from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.ndimage import gaussian_filter1d

from identification.dataset.series import Series, numbered_columns
from mechanism.arm import arm_of
from mechanism.cable_lengths import lengths
from mechanism.description import read_neck
from synchronisation.angle_meanings import other_meanings
from synchronisation.angles import Angles
from synchronisation.log_plausibility import check_log_meaning
from tests.paths import NECK_FILE
from xneck_foundation.errors import Refused

NECK = read_neck(NECK_FILE)
ARM = arm_of(NECK)
STIFFNESS = np.array([9e3, 7e3, 8e3, 6e3])
NOISE_RAD = np.radians(0.03)
EXCHANGES = [
    *((stems, pair) for stems in (("theta",), ("f",), ("theta", "f")) for pair in combinations(range(1, 5), 2)),
    *((("alpha",), pair) for pair in combinations(range(1, 4), 2)),
]


@pytest.fixture(scope="module")
def recording() -> tuple[Angles, Series]:
    """Joints that move nearly together, as where an arm reaches out and back, on cables that stretch as their forces say."""
    rng, time = np.random.default_rng(7), np.arange(0, 40, 2e-3)

    def smooth(count: int) -> np.ndarray:
        values = gaussian_filter1d(rng.normal(size=(len(time), count)), 150, axis=0)
        return values / values.std(axis=0)

    alpha = 0.2 * (0.9 * smooth(1) + 0.4 * smooth(ARM.N))
    f = 45 + 9 * smooth(ARM.M)
    elongation = f / STIFFNESS
    theta = (elongation - lengths(ARM, alpha) + lengths(ARM, np.zeros(ARM.N))) / ARM.drum
    frames = np.arange(0.1, 39.9, 1 / 30)
    angles = make_interp_spline(time, alpha)(frames) + rng.normal(0, NOISE_RAD, (len(frames), ARM.N))
    log = Series(time, numbered_columns("theta", theta) | numbered_columns("f", f))
    return Angles(frames, angles, np.full(angles.shape, NOISE_RAD)), log


def exchanged(angles: Angles, log: Series, stems: Sequence[str], pair: tuple[int, int]) -> tuple[Angles, Series]:
    """With the columns of a pair in each other's places."""
    a, b = pair
    if "alpha" in stems:
        order = np.arange(ARM.N)
        order[[a - 1, b - 1]] = b - 1, a - 1
        return Angles(angles.time, angles.alpha[:, order], angles.sigma[:, order]), log
    columns = dict(log.columns)
    for stem in stems:
        columns[f"{stem}{a}"], columns[f"{stem}{b}"] = columns[f"{stem}{b}"], columns[f"{stem}{a}"]
    return angles, Series(log.time, columns)


@pytest.mark.parametrize(("stems", "pair"), EXCHANGES, ids=[f"{' and '.join(s)} {a} {b}" for s, (a, b) in EXCHANGES])
def test_what_is_exchanged_is_named(
    recording: tuple[Angles, Series], stems: Sequence[str], pair: tuple[int, int]
) -> None:
    """Two motors that are told each other's angles seem to pull the wrong way, or to be in degrees: that was said of them."""
    a, b = pair
    motors = f"motors {a} and {b} are swapped, theta and f"
    what = motors if len(stems) == 2 else f"{stems[0]}{a} and {stems[0]}{b} are swapped"
    with pytest.raises(Refused, match=re.escape(what)) as refusal:
        check_log_meaning(NECK, ARM, *exchanged(*recording, stems, pair))
    assert re.search(r"[\d.]+ mm are left unexplained so, [\d.]+ as it is", str(refusal.value))


@pytest.mark.parametrize("order", [(1, 2, 3, 0), (3, 0, 1, 2), (2, 3, 0, 1), (1, 2, 0, 3)])
def test_forces_in_another_order_are_named_with_whose_each_is(
    recording: tuple[Angles, Series], order: tuple[int, ...]
) -> None:
    """Of four in a ring two were called swapped, which explains little."""
    angles, log = recording
    rotated = Series(log.time, {**log.columns, **numbered_columns("f", log.matrix("f")[:, order])})
    with pytest.raises(Refused, match=r"sync: f columns are in another order: ([^:]*): [\d.]+ mm") as refusal:
        check_log_meaning(NECK, ARM, angles, rotated)
    told = re.findall(r"f(\d) is motor (\d)'s", str(refusal.value))
    assert {(int(k) - 1, int(j) - 1) for k, j in told} == {(k, j) for k, j in enumerate(order) if k != j}


def test_motors_in_reverse_order_are_named_both_pairs(recording: tuple[Angles, Series]) -> None:
    """The first pair alone was named, and what was left to do found at the next try."""
    angles, log = recording
    turned = {stem: numbered_columns(stem, log.matrix(stem)[:, ::-1]) for stem in ("theta", "f")}
    with pytest.raises(
        Refused, match=r"sync: motors (\d) and (\d) are swapped, theta and f; and motors (\d) and (\d)"
    ) as refusal:
        check_log_meaning(NECK, ARM, angles, Series(log.time, turned["theta"] | turned["f"]))
    found = re.findall(r"motors (\d) and (\d) are swapped", str(refusal.value))
    assert {frozenset(pair) for pair in found} == {frozenset("14"), frozenset("23")}


OF_BARS = "alpha1..3 are angles of the bars in the picture, not from bar to bar"
FROM_TIP = "alpha1..3 are counted from the tip"


@pytest.mark.parametrize(
    ("read_as", "what", "remedy"),
    [
        (lambda a: np.cumsum(a, axis=1), OF_BARS, "the first is alpha1"),
        (lambda a: -np.cumsum(a, axis=1), f"{OF_BARS}, and turn the other way", "the first is alpha1"),
        (lambda a: np.cumsum(a, axis=1) + np.pi / 2, OF_BARS, "the first is alpha1 less 90 deg"),
        (
            lambda a: -a[:, ::-1],
            f"{FROM_TIP}, and turn the other way",
            "write the last one first, and all with the other sign",
        ),
    ],
)
def test_angles_that_are_not_from_bar_to_bar_are_named(
    recording: tuple[Angles, Series], read_as: Callable[[np.ndarray], np.ndarray], what: str, remedy: str
) -> None:
    """Of bars' angles motors were said to be in mm of cable, and of those from the tip to be swapped."""
    angles, log = recording
    with pytest.raises(Refused, match=re.escape(what + ":")) as refusal:
        check_log_meaning(NECK, ARM, Angles(angles.time, read_as(angles.alpha), angles.sigma), log)
    assert str(refusal.value).endswith(remedy)


def independent_joints(recording: tuple[Angles, Series], about: np.ndarray) -> tuple[Angles, Series]:
    """Joints that move by themselves, each about an angle (rad), with the same frames and forces."""
    angles, log = recording
    rng = np.random.default_rng(8)
    alpha = gaussian_filter1d(rng.normal(size=(len(log.time), ARM.N)), 150, axis=0)
    alpha = about + 0.2 * alpha / alpha.std(axis=0)
    theta = (log.matrix("f") / STIFFNESS - lengths(ARM, alpha) + lengths(ARM, np.zeros(ARM.N))) / ARM.drum
    own = Series(log.time, {**log.columns, **numbered_columns("theta", theta)})
    return Angles(angles.time, alpha[np.searchsorted(log.time, angles.time)], angles.sigma), own


def test_bars_angles_are_named_where_they_hardly_move_as_the_log_does(recording: tuple[Angles, Series]) -> None:
    """Joints that move against each other: sums of their angles are of another motion, one would say."""
    angles, own = independent_joints(recording, np.zeros(ARM.N))
    assert check_log_meaning(NECK, ARM, angles, own) == ()
    with pytest.raises(Refused, match=re.escape(OF_BARS)):
        check_log_meaning(NECK, ARM, Angles(angles.time, np.cumsum(angles.alpha, axis=1), angles.sigma), own)


@pytest.mark.parametrize(
    ("turns", "says"),
    [
        ((1, 0, 0), "alpha1 reads 90 deg while the arm stands straight.*; subtract 1.570796 from alpha1$"),
        ((0, -1, 0), "alpha2 reads -90 deg while the arm stands straight.*; add 1.570796 to alpha2$"),
        ((1, 1, 1), "alpha1, alpha2, alpha3 read 90 deg .*; subtract 1.570796 from alpha1, alpha2, alpha3$"),
        (
            (2, 0, -1),
            "alpha3 reads -90 deg and alpha1 reads 180 deg .*; add 1.570796 to alpha3 and subtract 3.141593 from",
        ),
    ],
)
def test_angles_that_read_quarter_turns_while_the_arm_stands_straight_are_named(
    recording: tuple[Angles, Series], turns: tuple[int, ...], says: str
) -> None:
    """Motors were said to be in degrees of the drum, or nothing was said and a marker was off by 69 deg."""
    angles, log = independent_joints(recording, np.zeros(ARM.N))
    read = Angles(angles.time, angles.alpha + np.pi / 2 * np.array(turns), angles.sigma)
    with pytest.raises(Refused, match=says):
        check_log_meaning(NECK, ARM, read, log)


@pytest.mark.parametrize("about_deg", [(50.0, 0.0, 0.0), (0.0, -55.0, 50.0)])
def test_an_arm_that_is_bent_all_along_reads_no_quarter_turn(
    recording: tuple[Angles, Series], about_deg: tuple[float, ...]
) -> None:
    assert check_log_meaning(NECK, ARM, *independent_joints(recording, np.radians(about_deg))) == ()


@pytest.mark.parametrize("told", [25.0, 7.5])
def test_a_frame_rate_that_a_tracker_was_told_wrongly_is_named(recording: tuple[Angles, Series], told: float) -> None:
    """The camera took 30 a second; of slow motion 7.5 are shown. It was said that the two are of other recordings."""
    angles, log = recording
    wrong = Angles(angles.time * 30 / told, angles.alpha, angles.sigma)
    what = f"frames are {told:g} a second by their times, and move as the log does only if they are 30; "
    with pytest.raises(Refused, match=re.escape(what)) as refusal:
        check_log_meaning(NECK, ARM, wrong, log)
    assert f"if the camera took 30, multiply their times by {told / 30:.4g}; " in str(refusal.value)


def test_a_log_rate_that_was_told_wrongly_is_thought_of_too(recording: tuple[Angles, Series]) -> None:
    """Rows of 500 a second with the times of 1000: the camera alone was blamed."""
    angles, log = recording
    assert 1 / np.median(np.diff(log.time)) == pytest.approx(500)
    with pytest.raises(Refused, match=r"are 500 a second and not 1000, multiply its times by 2$"):
        check_log_meaning(NECK, ARM, angles, Series(log.time / 2, log.columns))


def test_a_log_of_another_motion_is_of_no_other_frame_rate(recording: tuple[Angles, Series]) -> None:
    angles, log = recording
    other = Angles(angles.time, angles.alpha[::-1], angles.sigma)
    assert check_log_meaning(NECK, ARM, other, log) == ()


def test_nothing_is_exchanged_in_a_recording_that_is_right(recording: tuple[Angles, Series]) -> None:
    assert check_log_meaning(NECK, ARM, *recording) == ()


def test_joints_in_another_order_need_not_turn_the_other_way() -> None:
    """Of a log that did not move as the angles did only both at once were tried, and angles came out with the wrong sign."""
    alpha = np.random.default_rng(0).normal(size=(5, ARM.N))
    readings = {other.words: other.alpha for other in other_meanings(alpha)}
    assert np.array_equal(readings[FROM_TIP], alpha[:, ::-1])
    assert np.array_equal(readings[f"{FROM_TIP}, and turn the other way"], -alpha[:, ::-1])


def test_a_cable_that_moves_no_joint_is_refused(recording: tuple[Angles, Series]) -> None:
    """Its motor was said to have slipped, and the rope to be loose on its drum."""
    neck = NECK.model_copy(deep=True)
    cables = list(neck.cables)
    cables[1] = cables[1].model_copy(update={"route": ("strut", "strut")})
    neck = neck.model_copy(update={"cables": tuple(cables)})
    with pytest.raises(Refused, match=re.escape("cables[1] moves no joint")):
        check_log_meaning(neck, arm_of(neck), *recording)


@pytest.mark.parametrize("motors", [(1, 2, 3, 4), (3,)])
def test_a_drum_described_by_its_diameter_is_named(recording: tuple[Angles, Series], motors: tuple[int, ...]) -> None:
    """Motors were said to be in degrees of the drum, by a factor of .44 where .5 was measured."""
    doubled = [m.model_copy(update={"rd": 2 * m.rd}) if j in motors else m for j, m in enumerate(NECK.motors, start=1)]
    neck = NECK.model_copy(update={"motors": doubled})
    with pytest.raises(Refused, match=r"2 times as far as the video shows, as where motors\[\]\.rd is the diameter of"):
        check_log_meaning(neck, arm_of(neck), *recording)


def test_degrees_of_the_drum_are_not_taken_for_its_diameter(recording: tuple[Angles, Series]) -> None:
    """Control: with a gear of 25 they differ by .44 to .5."""
    angles, log = recording
    of_drum = log.matrix("theta") / np.radians(1) / NECK.motors[0].R
    read = Series(log.time, {**log.columns, **numbered_columns("theta", of_drum)})
    with pytest.raises(Refused, match="degrees of the drum"):
        check_log_meaning(NECK, ARM, angles, read)
