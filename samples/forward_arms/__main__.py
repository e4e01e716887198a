"""Writes arms with their recordings: python -m samples.forward_arms --out FOLDER --arms 4 --seconds 60 --noise-deg 0.02 --seed 0"""

import argparse
from dataclasses import fields
from pathlib import Path
from typing import Any

from samples.forward_arms.arms import make_arms
from samples.forward_arms.files import write_arm
from samples.forward_arms.given_motion import read_motion
from samples.forward_arms.settings import Settings

_OPTIONS = {
    "seconds": "of the log",
    "recordings": "of each arm",
    "mechanisms": "of each arm",
    "noise_deg": "standard deviation of the angles",
    "drawing_off": "how far arms are from their drawing, in standard deviations of a workshop",
    "delay": "s, of the command",
    "jitter": "s, standard deviation of the delay",
    "step": "s, of the integration",
    "camera_rate": "Hz",
    "dropped": "share of the frames",
}


def main() -> None:
    """Command line of the generator."""
    parser = argparse.ArgumentParser(prog="python -m samples.forward_arms", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for arm1, arm2, ...")
    parser.add_argument(
        "--play", type=Path, help="motion.csv of `xneck design`, played in the place of motions that are drawn"
    )
    parser.add_argument("--arms", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0, help="of the first arm; the next have the next")
    defaults = {f.name: f.default for f in fields(Settings)}
    for name, text in _OPTIONS.items():
        default = defaults[name]
        parser.add_argument(
            f"--{name.replace('_', '-')}", type=type(default), default=default, help=f"{text} ({default})"
        )
    for name, choices in (
        ("base", ("presliding", "near", "almost", "exact")),
        ("motion", ("rich", "slow")),
        ("motion-of", ("joints", "tensions")),
        ("tension", ("rich", "constant")),
    ):
        parser.add_argument(f"--{name}", choices=choices, default=defaults[name.replace("-", "_")])
    parser.add_argument("--sigma-columns", action="store_true", help="in alpha.csv")
    parser.add_argument("--unlike", action="store_true", help="mechanisms of one arm differ")
    parser.add_argument("--unlike-motors", action="store_true", help="motors of one arm differ")
    for name, text in (("damping", "N s/m of the cables"), ("exposure", "s"), ("tension-range", "N")):
        default = defaults[name.replace("-", "_")]
        parser.add_argument(
            f"--{name}", type=float, nargs=2, default=default, help=f"least and greatest {text} ({default})"
        )
    chosen: dict[str, Any] = vars(parser.parse_args())
    out, seed, arms, play = (chosen.pop(name) for name in ("out", "seed", "arms", "play"))
    motions = [read_motion(play)] * arms if play else None
    for name in ("damping", "exposure", "tension_range"):
        chosen[name] = tuple(chosen[name])
    settings = Settings(**chosen)
    for i, arm in enumerate(make_arms(range(seed, seed + arms), settings, motions=motions)):
        write_arm(arm, out / f"arm{i + 1}", settings)


if __name__ == "__main__":
    main()
