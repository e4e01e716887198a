"""Laws hidden in residuals, drawn anew for each seed: found by ours and by SINDy, beside what a Gaussian process could explain.

Half of every recording is fitted, the other half judged. SINDy chooses among polynomials of two variables and harmonics of each,
as its users would; its threshold is the one that does best on blocks of the fitted half that it was not fitted to.
"""

import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.figures.rate import Rate
from benchmarks.table import Claim, Table
from discovery.discover import discover

Array = NDArray[np.float64]
Signals = Mapping[str, Array]
Law = Callable[[Signals, Array, np.random.Generator], Array]

SEEDS = range(1003, 1011)
SECONDS, STEP = 120.0, 0.02
NOISE, MEMORY = 0.3, 0.5
"""RMS of the innovation, and how much of it stays from row to row"""
SIZE = 0.5
"""RMS of a law along the recording, before it is drawn between this and three times as much"""
THRESHOLDS = (0.02, 0.05, 0.1, 0.2, 0.4)
HARMONICS = 9
GP_ROWS = 700


def _way(s: Signals) -> Array:
    return np.clip(s["motor_speed"] / 0.3, -1, 1)


def _hinge(s: Signals, t: Array, rng: np.random.Generator) -> Array:
    return np.maximum(s["joint_angle"] - np.quantile(s["joint_angle"], rng.uniform(0.4, 0.8)), 0)


def _place(s: Signals, t: Array, rng: np.random.Generator) -> Array:
    away = np.angle(np.exp(1j * (s["motor_angle"] - rng.uniform(-3, 3))))
    return np.exp(-((away / rng.uniform(0.3, 0.7)) ** 2)) * _way(s)


def _level(s: Signals, t: Array, rng: np.random.Generator) -> Array:
    at = rng.uniform(40, 100)
    return s["force"] - at * np.tanh(s["force"] / at)


LAWS: Mapping[str, tuple[Law, frozenset[str]]] = {
    "teeth": (
        lambda s, t, rng: np.sin(rng.integers(3, 10) * s["motor_angle"] + rng.uniform(0, 6)),
        frozenset({"motor_angle"}),
    ),
    "drum": (lambda s, t, rng: np.cos(s["drum_angle"] + rng.uniform(0, 6)), frozenset({"drum_angle"})),
    "tight place": (_place, frozenset({"motor_angle", "motor_speed"})),
    "hinge": (_hinge, frozenset({"joint_angle"})),
    "levels off": (_level, frozenset({"force"})),
    "rubs by load": (
        lambda s, t, rng: s["force"] ** rng.uniform(1.0, 1.6) * _way(s),
        frozenset({"force", "motor_speed"}),
    ),
    "air": (lambda s, t, rng: s["joint_speed"] * np.abs(s["joint_speed"]), frozenset({"joint_speed"})),
    "warming": (lambda s, t, rng: np.exp(-t / rng.uniform(15, 40)) * _way(s), frozenset({"time", "motor_speed"})),
    "two": (lambda s, t, rng: s["force"] * s["joint_angle"], frozenset({"force", "joint_angle"})),
    "nothing": (lambda s, t, rng: np.zeros(len(t)), frozenset()),
}
"""with what each follows"""
OURS, SINDY, GP = "xneck.discover", "pysindy", "Gaussian process"
COLUMNS = (
    "worlds",
    "variables right, %",
    "95 % from",
    "to",
    "false in nothing",
    "residual / noise",
    "worst",
    "s a world",
)


@dataclass(frozen=True)
class _Found:
    right: bool
    is_law: bool
    ratio: float
    """residual of the half that was not fitted, over its noise"""
    seconds: float


def measure() -> Table:
    """Variables that are named rightly, and what is left where it was not fitted, over noise."""
    found: dict[str, list[tuple[str, _Found]]] = {OURS: [], SINDY: [], GP: []}
    for seed in SEEDS:
        for name, (law, follows) in LAWS.items():
            signals, t, noise, rng = _world(seed, name)
            shape = law(signals, t, rng)
            spread = float(np.std(shape))
            target = noise + (shape * SIZE * rng.uniform(1, 3) / spread if spread else 0.0)
            for way, fit in ((OURS, _ours), (SINDY, _sindy), (GP, _process)):
                began = time.process_time()
                said, left = fit(signals, t, target)
                half = len(t) // 2
                ratio = float(np.std(left[half:]) / np.std(noise[half:]))
                spent = time.process_time() - began
                found[way].append((name, _Found(said == follows, bool(said), ratio, spent)))
    rows = tuple((way, _figures(way, results)) for way, results in found.items())
    ours, theirs, best = (dict(rows)[way] for way in (OURS, SINDY, GP))
    claim = Claim(
        "residual over noise, not fitted, mean",
        f"{len(SEEDS) * (len(LAWS) - 1)} hidden laws",
        ours[5],
        (SINDY, theirs[5]),
        (GP, best[5]),
    )
    return Table("Laws hidden in residuals of 60 s, judged on the next 60 s", COLUMNS, rows, (claim,))


def _figures(way: str, results: list[tuple[str, _Found]]) -> tuple[float | None, ...]:
    hidden = [f for name, f in results if name != "nothing"]
    right = Rate(sum(f.right for f in hidden), len(hidden))
    named = (100 * right.count / right.of, *right.interval_percent) if way != GP else (None, None, None)
    nothing = sum(f.is_law for name, f in results if name == "nothing")
    ratios = [f.ratio for f in hidden]
    seconds = float(np.mean([f.seconds for _, f in results]))
    return (len(hidden), *named, None if way == GP else nothing, float(np.mean(ratios)), max(ratios), seconds)


def _world(seed: int, name: str) -> tuple[Signals, Array, Array, np.random.Generator]:
    rng = np.random.default_rng([2200, seed, *name.encode()])
    t = np.arange(0.0, SECONDS, STEP)

    def sum_of_sines(size: float) -> Array:
        waves = zip(rng.uniform(0.3, 1, 5), rng.uniform(0.3, 5, 5), rng.uniform(0, 6, 5), strict=True)
        return size * np.sum([a * np.sin(w * t + p) for a, w, p in waves], axis=0)

    theta, alpha = sum_of_sines(12.0), sum_of_sines(0.25)
    signals = {
        "motor_angle": theta,
        "drum_angle": theta / 6.3,
        "motor_speed": np.gradient(theta, t),
        "force": np.abs(55 + sum_of_sines(12.0)),
        "joint_angle": alpha,
        "joint_speed": np.gradient(alpha, t),
    }
    noise = np.asarray(lfilter([1.0], [1.0, -MEMORY], rng.normal(0, NOISE, len(t))))
    return signals, t, noise, rng


def _ours(s: Signals, t: Array, target: Array) -> tuple[frozenset[str], Array]:
    half = len(t) // 2
    found = discover(target[:half], {name: v[:half] for name, v in s.items()}, t[:half])
    follows = frozenset(name for law in found.laws for name in law.candidate.follows)
    return follows, _about_mean(target - found.values(s, t), half)


def _about_mean(left: Array, half: int) -> Array:
    return left - left[:half].mean()


def _sindy(s: Signals, t: Array, target: Array) -> tuple[frozenset[str], Array]:
    import pysindy as ps

    half, names = len(t) // 2, [*s, "time"]
    x = np.column_stack([*s.values(), t])
    # amounts are thresholds' matter: all columns of one size
    library = ps.PolynomialLibrary(degree=2, include_bias=True) + ps.FourierLibrary(n_frequencies=HARMONICS)
    scaled = x / np.array(
        [1.0 if name.endswith("angle") else np.std(v[:half]) for name, v in zip(names, x.T, strict=True)]
    )
    columns = np.asarray(library.fit_transform(scaled))
    labels = library.get_feature_names(names)
    size = np.maximum(np.std(columns[:half], axis=0), 1e-9)
    size[[label == "1" for label in labels]] = 1.0
    best: tuple[float, Array] | None = None
    blocks = np.arange(half) * 20 // half
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for threshold in THRESHOLDS:
            loss, fold = 0.0, blocks % 5
            for f in range(5):
                weights = _stlsq(ps, columns[:half][fold != f] / size, target[:half][fold != f], threshold)
                loss += float(np.sum((target[:half] - columns[:half] / size @ weights)[fold == f] ** 2))
            if best is None or loss < best[0]:
                best = loss, _stlsq(ps, columns[:half] / size, target[:half], threshold)
    assert best is not None
    weights = best[1]
    used = [label for label, w in zip(labels, weights, strict=True) if w and label != "1"]
    follows = frozenset(name for name in names if any(name in label for label in used))
    return follows, target - columns / size @ weights


def _stlsq(ps: object, columns: Array, target: Array, threshold: float) -> Array:
    optimizer = ps.STLSQ(threshold=threshold, alpha=1e-3)  # type: ignore[attr-defined]
    return np.asarray(optimizer.fit(columns, target[:, None]).coef_)[0]


def _process(s: Signals, t: Array, target: Array) -> tuple[frozenset[str], Array]:
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    half = len(t) // 2
    turns = [v for name in ("motor_angle", "drum_angle") for v in (np.cos(s[name]), np.sin(s[name]))]
    rest = [v for name, v in s.items() if not name.endswith("_angle") or name == "joint_angle"]
    x = np.column_stack([*turns, *rest, np.clip(s["motor_speed"] / 0.3, -1, 1), t])
    x = (x - x[:half].mean(axis=0)) / x[:half].std(axis=0)
    rows = np.linspace(0, half - 1, GP_ROWS).astype(int)
    kernel = ConstantKernel(1.0) * RBF([2.0] * x.shape[1], (0.05, 1e4)) + WhiteKernel(0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        process = GaussianProcessRegressor(kernel, normalize_y=True).fit(x[rows], target[rows])
        made = np.concatenate([process.predict(part) for part in np.array_split(x, 20)])
    return frozenset(), _about_mean(np.asarray(target - made, dtype=float), half)
