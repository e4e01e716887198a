"""A pair of recordings of one arm that hides something: one to fit, one to hold out, as files and with their truth."""

import json
import zlib
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from samples.generator.files import write_angles_csv, write_log_csv
from samples.generator.hidden.arms import Arm, described, random_arm
from samples.generator.hidden.effects import CATALOGUE
from samples.generator.hidden.kind import Draw, Hidden, Kind
from samples.generator.hidden.outside import OUTSIDE
from samples.generator.laws import ahead, dry_and_viscous, linear
from samples.generator.motion import LEVEL_N
from samples.generator.prescribed import Prescribed, World, prescribe
from samples.generator.taut_string import Array

RECORDINGS = ("fitted", "held_out")
KINDS: dict[str, Kind] = OUTSIDE | CATALOGUE
"""everything that can be hidden, in the order in which it is laid on"""
MANNERS = ("rich", "slow", "constant tension")
_LEAST_SIGMA = 1e-6
"""rad, the step of the file"""


def hide(
    kinds: Sequence[str],
    seed: int,
    folder: Path,
    *,
    seconds: tuple[float, float] = (60.0, 60.0),
    cad: float = 0.01,
    noise_deg: float = 0.1,
    manner: str = "rich",
    size: float = 1.0,
) -> tuple[Hidden, ...]:
    """Writes folder/fitted and folder/held_out with recording.yaml, neck.yaml, angles.csv, log.csv, and folder/truth.json.

    Both are of the same arm with the same effects, in other motions, with other clocks and noise. neck.yaml says what its
    engineer believes: dimensions off by up to `cad`, and no effect. manner: one of MANNERS.

    Raises ValueError for a name that is not in KINDS or MANNERS, and where no motion allows what is asked for.
    """
    for given, known in ((kinds, KINDS), ([manner], MANNERS)):
        if unknown := set(given) - set(known):
            raise ValueError(f"{', '.join(sorted(unknown))} is none of {', '.join(known)}")
    arm = random_arm(np.random.default_rng([seed, 1]))
    said = described(arm.neck, cad, np.random.default_rng([seed, 2]))
    sigma = np.radians(noise_deg)
    hidden: tuple[Hidden, ...] = ()
    about: dict[str, Any] = {}
    for number, (name, duration) in enumerate(zip(RECORDINGS, seconds, strict=True)):
        world, hidden = _world(arm, kinds, seed, number, seconds, size)
        made = _moved(world, duration, [seed, 3, number], manner)
        noise = np.random.default_rng([seed, 4, number]).normal(0, sigma, made.frame_seen.shape)
        _write(folder / name, said, made, made.frame_seen + noise, max(sigma, _LEAST_SIGMA))
        about[name] = asdict(made.clocks)
    truth = {
        "seed": seed,
        "kinds": list(kinds),
        "hidden": [asdict(h) for h in hidden],
        "fs": arm.fs.tolist(),
        "k": arm.k.tolist(),
        "ca": arm.ca.tolist(),
        "sharpness": arm.sharpness,
        "delay_s": arm.delay_s,
        "neck": arm.neck,
        "clocks": about,
    }
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    return hidden


def _world(
    arm: Arm, kinds: Sequence[str], seed: int, number: int, seconds: tuple[float, float], size: float
) -> tuple[World, tuple[Hidden, ...]]:
    """The arm with all its effects, as recording `number` meets it. Each effect draws from a stream of its own."""
    world = World(
        arm.neck,
        stretch=linear(arm.k, arm.ca),
        friction=dry_and_viscous(arm.fs, np.zeros(len(arm.fs)), arm.sharpness),
        written=lambda force, step: ahead(force, step, arm.delay_s),
    )
    hidden: list[Hidden] = []
    for name in (name for name in KINDS if name in kinds):
        stream = [seed, 5, zlib.crc32(name.encode())]
        rng, own = np.random.default_rng(stream), np.random.default_rng([*stream, number])
        world, one = KINDS[name](
            world, Draw(arm=arm, rng=rng, own=own, seconds=seconds[number], longest=max(seconds), size=size)
        )
        hidden.append(one)
    return world, tuple(hidden)


def _moved(world: World, seconds: float, seed: list[int], manner: str) -> Prescribed:
    rng = np.random.default_rng([*seed, 1])
    hertz = (rng.uniform(0.08, 0.15), rng.uniform(0.9, 1.4))
    if manner == "slow":
        hertz = (0.02, 0.15)
    level = (LEVEL_N[0], 0.0) if manner == "constant tension" else LEVEL_N
    return prescribe(world, seconds, seed, hertz, level_n=level)


def _write(folder: Path, neck: dict[str, Any], made: Prescribed, alpha: Array, sigma: float) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    files = {"log": "log.csv", "neck": "neck.yaml", "angles": "angles.csv"}
    (folder / "recording.yaml").write_text(yaml.safe_dump(files), encoding="utf-8")
    (folder / "neck.yaml").write_text(yaml.safe_dump(neck, sort_keys=False), encoding="utf-8")
    write_angles_csv(folder / "angles.csv", made.frame_times, alpha, np.full(alpha.shape, sigma))
    write_log_csv(folder / "log.csv", made.log_time, made.counted, made.f)
