"""Seeds on which something was set or mended: they are counted in no rate that is reported.

A seed that was counted first and used for setting something afterwards stands here too: another run of it proves nothing.
Three generators take seeds, and the same seed is another world in each.
"""

from collections.abc import Mapping, Sequence
from itertools import chain

_RULES = "the rules and thresholds of the diagnosis were set on it"
_FIRST_TABLE = "run for the first table of the study, after which the gates of the diagnosis were set anew"
_MENDED = "looked into after it was counted; the columns of cables with memory and the set of causes that explain alike were mended"
_SLOW = "the clock of slow motion, and what counts as a lost frame there, were mended on it"

_ARMS: tuple[tuple[range, str], ...] = (
    (range(2), _RULES),
    (range(71, 74), "mirrored arms in slow motion: when another arm than the described one is named"),
    (range(110, 112), _FIRST_TABLE),
    (range(120, 123), "hysteresis, pulley friction and creep of the diagnosis were mended after it was counted"),
    (range(131, 137), _MENDED),
    (range(137, 138), "fits of friction near rest begin anew where they end in friction that drives"),
    (
        range(138, 139),
        "run again while the clock's late commands and the columns of cables with memory were mended",
    ),
    (range(139, 140), "whether a cause holds on other recordings is judged channel by channel"),
    (range(200, 206), "pairs: a rule for a further cause was set on the one that was missed"),
    (range(210, 218), "pairs: what a motor that lags leaves was looked into and mended"),
    (range(500, 501), "short recordings: a cause that does not hold on other recordings is insufficient"),
    (range(510, 511), "slow motion and constant tension were looked into on it"),
    (range(521, 530), _SLOW),
    (range(7700, 7708), "when a frame repeats the picture before it"),
    (range(910, 912), "the clock's late commands and friction's transition were found on it"),
    (range(915, 916), "when a log's theta or f is taken to be in another unit"),
)

TUNED_SEEDS: Mapping[int, str] = dict(chain.from_iterable(((seed, why) for seed in seeds) for seeds, why in _ARMS))
"""Arms of `xneck study` (samples/generator/hidden): seed, and what was set on it."""

_WORLDS: tuple[tuple[range, str], ...] = (
    (
        range(6),
        "tolerances of `check` were raised after a false alarm; fused state: the test whether cables are believed",
    ),
    (
        range(6, 16),
        "fused state: the test whether cables are believed; z of `check` in recordings of 8 to 12 s",
    ),
    (range(16, 21), "z of `check` in recordings of 8 to 12 s"),
    (range(41, 42), "when a rope counts as having moved on its drum"),
    (range(43, 48), "when a rope counts as having moved on its drum"),
    (range(70, 72), "the tests of `check` stand on it"),
    (range(100, 103), "the tests of the clock, of labels and of lost frames stand on it"),
    (range(110, 116), "the least rate of a log, and when its theta or f is taken to be in another unit"),
    (range(1000, 1050), "the systematic part of the clock's sigma"),
    (range(3000, 3036), "the clock at other rates of frames and rows, and lost frames beside slips"),
)

TUNED_WORLDS: Mapping[int, str] = dict(chain.from_iterable(((seed, why) for seed in seeds) for seeds, why in _WORLDS))
"""Worlds of the clock's, the check's and the state's benchmarks: seed, and what was set on it."""

_TOLERANCES = "how causes are chosen jointly beside tolerances, when one is named, and when something unknown remains"

_FORWARD_ARMS: tuple[tuple[Sequence[int], str], ...] = (
    (range(64), "how the noise of angles is read from their frames, and knots and rough motion of the state"),
    (range(1, 9), "the smoother of motor speeds, and up to which frequency the arm's equation is judged"),
    (
        range(300, 310),
        f"lags of cables, the motors' equation in integral form and the systematic part of the clock's sigma; {_TOLERANCES}",
    ),
    (
        range(310, 312),
        "lags of cables, the motors' equation in integral form and the systematic part of the clock's sigma",
    ),
    (range(340, 370), f"the clock with laws that are hidden; losses that a rest feigns; {_TOLERANCES}"),
    (range(380, 395), f"the clock with friction of another form and with drawings that are off; {_TOLERANCES}"),
    (
        range(400, 437),
        "weights that are told anew, memory where a recording begins, and laws that nobody listed; with mixtures whose pulleys "
        "rubbed by a part of the tension only",
    ),
    (
        range(481, 485),
        "laws that nobody listed: their forms, and what a law must gain, and that one which does not hold ends nothing; "
        "joints and cables that stick",
    ),
    (range(1501, 1506), "counted first; then why two laws at once are not found was looked into"),
    (
        range(450, 481),
        "arms of 1 to 6 mechanisms and 1 to 8 cables: how well clocks take the motors' inertia to be known",
    ),
    (
        (*range(437, 450), *range(495, 500)),
        "with poor motions: how long and how poor they are, and how a designed motion is judged; creep that began before the log",
    ),
    (
        (1165, 1166),
        "counted first; with a wrong gain, what is tried where a joint choice of causes misleads was set on the first",
    ),
    (range(1162, 1165), "counted first; then a function of the force that takes most of it was refused"),
    (range(1200, 1206), "what stands in for effects of no catalogue was looked at"),
    (
        range(1000, 1003),
        "where the rounds that tell rough motion from errors of cables begin; the last was only looked at",
    ),
    (
        (1702,),
        "counted first; then angles entered what a clock leaves unexplained, and motors that would drive its sigma",
    ),
    (
        range(1710, 1712),
        "counted first; then numbers of the drawing kept to their tolerances beside causes, and fits of hardening were looked into",
    ),
    (
        range(1301, 1306),
        "counted first; then the last step of a fit, steps of shapes, needless causes and the held-out floor were mended",
    ),
    ((5114,), "counted first; then stiffness and pre-elongations that were not identified were begun anew"),
    (
        (5100, 5101, 5103),
        "counted first; then slow rows were left out of the observer's health, as two were said to be changed",
    ),
    ((345304,), "of a test that is drawn anew with each commit; then pulleys became free before another arm is tried"),
    (
        range(5000, 5012),
        "noises, sigmas and limits of the observer and of what it is calibrated with; the tests stand on the last two",
    ),
    (
        (1555, 1564),
        "counted first at 0.005 deg; then causes that no amount tells were given up where nothing is above noise",
    ),
    (
        range(1720, 1722),
        "counted first; then a cause that turned out impossible was no more chosen again, and needed ones no more fitted without",
    ),
    (
        (1729, 1741),
        "counted first; then looked into for the time that fits take, and for a law of another form in a cause's place",
    ),
    (
        (1725, 1728),
        "counted first; then clocks of lagging motors, and what sends a clock's fit away, were mended",
    ),
    (range(40, 52), "how far the state follows fast motion, and the variance of its cables' nuisances"),
)

TUNED_FORWARD_ARMS: Mapping[int, str] = dict(
    chain.from_iterable(((seed, why) for seed in seeds) for seeds, why in _FORWARD_ARMS)
)
"""Arms of samples/forward_arms: seed, and what was set on it."""

FIRST_COUNTED_FORWARD_ARM = 1003
"""The seed from which arms integrated forward are counted: nothing was ever set on these; those below 500 are for setting."""

FIRST_COUNTED_WORLD = 2000
"""The seed from which these benchmarks count, some dozens of them: nothing was ever set on these."""

_TONE = "the tone curve, markers that stand still, systematic offsets, and small markers' first light were mended on it"

TUNED_FILMS: Mapping[int, str] = dict.fromkeys((*range(100, 119), *range(2001, 2005), *range(5001, 5005)), _TONE) | {
    3015: "counted first; then the least size of a motion of the camera was set by its false one"
}
"""Worlds of samples/second_camera: seed, and what was set on it."""

TUNED_MOUNTED_ARMS: Mapping[int, str] = dict.fromkeys(
    range(7301, 7307), "markers that stand still, and the fastest rolling shutter, were set on it"
)
"""Arms of samples/generator/mounted.py: seed, and what was set on it."""
