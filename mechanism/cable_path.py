"""The way of a cable in the plane: straight pieces, and arcs on the pulleys between them.

The same way whose length `cable_lengths` states in closed form: from the lowest point of the base's pulley, which turns with the
base bar, to the cable's end. On the right a cable turns counter-clockwise around its pulleys, outside of the arm, on the left
clockwise; over a strut it crosses to the other side, so that it turns the other way there, and crosses back along the top bar.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechanism.arm import Arm, Array
from mechanism.description import SIDE_OF
from mechanism.geometry import Poses, poses

_DOWN = -np.pi / 2
_ARC_STEP = np.radians(5)
_RIGHT, _LEFT = 1, 0


@dataclass(frozen=True)
class Contact:
    """A cable on a pulley: it turns from angle `begin` to `end` (rad) around `centre` (m, complex)."""

    centre: complex
    radius: float
    begin: float
    end: float

    @property
    def points(self) -> NDArray[np.complexfloating[Any, Any]]:
        """Along the arc, (P,), m."""
        count = max(2, int(np.ceil(abs(self.end - self.begin) / _ARC_STEP)) + 1)
        return self.centre + self.radius * np.exp(1j * np.linspace(self.begin, self.end, count))


def bar_ends(arm: Arm, pose: Poses) -> NDArray[np.complexfloating[Any, Any]]:
    """Ends of bars 0..N: left, then right, (N + 1, 2), m."""
    half = np.concatenate([arm.b[:1], arm.b]) / 2
    return pose.bar_middle[:, None] + half[:, None] * np.exp(1j * pose.bar_angle[:, None]) * np.array([-1.0, 1.0])


def cable_contacts(arm: Arm, alpha: Array, cable: int, wider: float = 0.0) -> list[Contact]:
    """The pulleys that a cable, counted from 0, winds around at joint angles alpha (N,), rad, from the base's on.

    wider: m, by which the cable is drawn outside of each pulley's radius, so that several on one pulley can be told apart. A cable
    that ends at a pulley's centre has a last contact of radius zero.
    """
    pose = poses(arm, alpha)
    ends, contacts = bar_ends(arm, pose), list[Contact]()
    for i, word in enumerate(arm.routes[cable]):
        side = _RIGHT if SIDE_OF[word] == "right" else _LEFT
        turn = 1.0 if side == _RIGHT else -1.0
        r = float(arm.r[i]) + wider
        first, last = complex(ends[i, side]), complex(ends[i + 1, side])
        if word.startswith("strut"):
            stops = [(first, r, turn), (complex(ends[i + 1, 1 - side]), r, -turn), (last, r, turn)]
        else:
            stops = [(first, r, turn), (last, r if word.endswith("_through") else 0.0, turn)]
        lowest = _DOWN + pose.bar_angle[i], _DOWN + pose.bar_angle[i + 1]
        contacts += _portion(stops, float(lowest[0]), float(lowest[1]))
    return contacts


def path_points(contacts: list[Contact]) -> NDArray[np.complexfloating[Any, Any]]:
    """A cable's way as points, (P,), m; pieces between contacts are straight."""
    return np.concatenate([contact.points for contact in contacts])


def path_length(contacts: list[Contact]) -> float:
    """Length of a cable's way, m: its arcs and the straight pieces between them."""
    arcs = sum(c.radius * abs(c.end - c.begin) for c in contacts)
    return float(arcs + sum(abs(b.points[0] - a.points[-1]) for a, b in pairwise(contacts)))


def _portion(stops: list[tuple[complex, float, float]], begin: float, end: float) -> list[Contact]:
    """Contacts of one mechanism's portion, from the lowest point of its first pulley to that of its last.

    stops: centre, radius, and 1 where the cable turns counter-clockwise, -1 where it turns clockwise.
    """
    arrivals, departures = [begin], []
    for (a, ra, turn_a), (b, rb, turn_b) in pairwise(stops):
        # the pulleys lie at turn * radius to the left of the straight piece
        along = np.angle(b - a) + np.arcsin((turn_a * ra - turn_b * rb) / abs(b - a))
        departures.append(float(along - turn_a * np.pi / 2))
        arrivals.append(float(along - turn_b * np.pi / 2))
    departures.append(end if stops[-1][1] else arrivals[-1])
    return [
        Contact(
            centre, radius, arrived, arrived + turn * (turn * (left - arrived) % (2 * np.pi)) if radius else arrived
        )
        for (centre, radius, turn), arrived, left in zip(stops, arrivals, departures, strict=True)
    ]
