"""A motion that is played as it was designed: joint angles and tensions from a table such as `xneck design` writes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from samples.forward_arms.motion import Asked
from samples.forward_arms.plant import Array


@dataclass(frozen=True)
class GivenMotion:
    """Rows of a table, from rest to rest."""

    time: Array
    """(T,), s, from 0"""
    alpha: Array
    """(T, N), rad"""
    tension: Array
    """(T, M), N"""

    @property
    def seconds(self) -> float:
        """From the first row to the last."""
        return float(self.time[-1])

    def asked(self, time: Array) -> Asked:
        """At log times `time` (s); before and after the table the arm rests as its first and its last row say."""
        alpha, tension = (
            np.stack([np.interp(time, self.time, column) for column in columns.T])
            for columns in (self.alpha, self.tension)
        )
        return Asked(alpha, tension)


def read_motion(path: Path) -> GivenMotion:
    """A table with columns time, alpha1..N and tension1..M; others are left aside."""
    names = path.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)

    def columns(name: str) -> Array:
        found = [i for i, column in enumerate(names) if column[: len(name)] == name and column[len(name) :].isdigit()]
        if not found:
            raise ValueError(f"{path}: no columns {name}1, {name}2, ...")
        return table[:, found]

    return GivenMotion(table[:, names.index("time")], columns("alpha"), columns("tension"))
