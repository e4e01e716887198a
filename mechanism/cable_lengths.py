"""Cable lengths l(alpha), with pulleys and without, and the matrix Z = -dl/dalpha.

The portion of a cable in a mechanism runs from the lowest point of its entry pulley (turning with the bottom bar) to its
end, or to the lowest point of its exit pulley (turning with the top bar). Where a cable passes a shared pulley we assume
the full turn that (24) counts; without it the cable would lift off for alpha_i + alpha_(i+1) < 0.
"""

from dataclasses import dataclass

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.batch_layout import arm_batch_last, batch_shape, from_batch_last, to_batch_last
from mechanism.geometry import Sides, sides

MAX_BATCH_OF_POSES = 1 << 12
"""poses that are computed at once: what they need stays in a cache"""


@dataclass(frozen=True)
class Portion:
    """Length of a cable portion with its derivative by alpha, each (...), m, and its angle of wrap, rad."""

    length: Array
    d1: Array
    wrap: Array
    wrap_above: Array
    """of that angle, what lies beyond the span that the mechanism changes: there the cable slides by what changes above"""


def lengths(arm: Arm, alpha: Array) -> Array:
    """(31)-(34): lengths of the cables from the base's pulleys on, shape (..., M), m; alpha of shape (..., N), rad."""
    return geometry_of_poses(arm, alpha).length


def wrap_angles(arm: Arm, alpha: Array) -> Array:
    """Angle by which each cable is wound around the pulleys of its route, in all, shape (..., M), rad."""
    return geometry_of_poses(arm, alpha).wrap


def Z(arm: Arm, alpha: Array) -> Array:
    """(3): Z(i, j) = -dl_j/dalpha_i, shape (..., N, M), m."""
    return geometry_of_poses(arm, alpha).Z


def Z_dot(arm: Arm, alpha: Array, alpha_d: Array) -> Array:
    """dZ/dt, shape (..., N, M), m/s: each entry depends on its own angle only."""
    s = sides(arm, alpha)
    values = {word: _SECOND_DERIVATIVE[word](arm, alpha, s) for route in arm.routes for word in route}
    d2 = np.zeros((*s.d.shape, arm.M))
    for j, route in enumerate(arm.routes):
        for i, word in enumerate(route):
            d2[..., i, j] = values[word][..., i]
    return -d2 * np.asarray(alpha_d)[..., None]


def lengths_without_pulleys(arm: Arm, alpha: Array) -> Array:
    """(7)-(10): the same cables when pulleys have no radius and struts are followed bar by bar, shape (..., M), m."""
    s = sides(arm, alpha)
    strut = np.broadcast_to(arm.L + arm.b, s.d.shape)
    piece = {"right": s.right, "left": s.left, "strut": strut, "strut_mirrored": strut}
    piece |= {"right_through": s.right, "left_through": s.left}
    per_cable = [sum(piece[word][..., i] for i, word in enumerate(route)) for route in arm.routes]
    return np.stack(np.broadcast_arrays(*per_cable), axis=-1)


@dataclass(frozen=True)
class PoseGeometry:
    """All cables in many poses: lengths (..., M), m, angles of wrap (..., 2 N, M), rad, and Z (..., N, M), m."""

    length: Array
    wraps: Array
    """first on the pulleys of each mechanism that slide as its span does, then on those that slide as what is above it"""
    Z: Array

    @property
    def wrap(self) -> Array:
        """In all, (..., M), rad."""
        return self.wraps.sum(axis=-2)


def geometry_of_poses(arm: Arm, alpha: Array) -> PoseGeometry:
    """Lengths, angles of wrap and Z together; alpha of shape (..., N), rad."""
    shape = np.broadcast_shapes(np.shape(alpha)[:-1], batch_shape(arm, {}))
    count = int(np.prod(shape))
    length, wraps, jacobian = (np.empty((*axes, arm.M, count)) for axes in ((), (2 * arm.N,), (arm.N,)))
    for begin in range(0, count, MAX_BATCH_OF_POSES):
        part = slice(begin, min(begin + MAX_BATCH_OF_POSES, count))
        g = cable_geometry(arm_batch_last(arm, shape, part), to_batch_last(alpha, shape, part))
        length[:, part], wraps[..., part], jacobian[..., part] = g.length, g.wraps, g.Z
    return PoseGeometry(*(from_batch_last(values, shape) for values in (length, wraps, jacobian)))


@dataclass(frozen=True)
class CableGeometry:
    """All cables in one pose, in batch layout: lengths (M, B), m, angles of wrap (2 N, M, B), rad, and Z (N, M, B), m."""

    length: Array
    wraps: Array
    """as in `PoseGeometry`"""
    Z: Array

    @property
    def wrap(self) -> Array:
        """In all, (M, B), rad."""
        total = self.wraps[0]
        for more in self.wraps[1:]:
            total = total + more
        return total

    def stretch(self, drum: Array, joints: Array, motors: Array) -> Array:
        """(42): (rd/R) motors - Z^T joints, (M, B): change, or rate, of the elongations by those of joints and motors."""
        return drum * motors - np.einsum("ijb,ib->jb", self.Z, joints)

    def torque(self, t: Array) -> Array:
        """Z t, (N, B), N m; t (M, B), N."""
        return np.einsum("ijb,jb->ib", self.Z, t)


def cable_geometry(arm: Arm, alpha: Array) -> CableGeometry:
    """Lengths, angles of wrap and Z together; arm in batch layout, alpha (N, B)."""
    portion_of = portions(arm, alpha)
    shape = np.broadcast_shapes(alpha.shape, arm.L.shape, arm.b.shape, arm.r.shape)
    length, wraps, jacobian = (
        np.zeros_like(alpha, shape=(*axes, *shape[1:])) for axes in ((arm.M,), (2 * arm.N, arm.M), (arm.N, arm.M))
    )
    for j, route in enumerate(arm.routes):
        for i, word in enumerate(route):
            length[j] += portion_of[word].length[i]
            jacobian[i, j] = -portion_of[word].d1[i]
            wraps[arm.N + i, j] = portion_of[word].wrap_above[i]
            wraps[i, j] = portion_of[word].wrap[i] - wraps[arm.N + i, j]
    return CableGeometry(length, wraps, jacobian)


def portions(arm: Arm, alpha: Array) -> dict[str, Portion]:
    """The portion that each route word in use would have in each mechanism, arrays of shape (..., N)."""
    s = sides(arm, alpha)
    words = {word for route in arm.routes for word in route}
    return {word: _PORTION[word](arm, alpha, s) for word in words}


def _ends(side: Array, d1: Array, arm: Arm, alpha: Array, sign: float) -> Portion:
    """(19), (20): along a side to the centre of the upper pulley; sign -1 on the left, +1 on the right."""
    r = arm.r
    t = np.sqrt(side**2 - r**2)
    wrap = np.pi + sign * alpha / 2 - np.arctan2(t, r)
    # d/dl of t - r atan(t/r) is t/l: the tangent's share of the side
    return Portion(t + r * wrap, d1 * t / side + sign * r / 2, wrap, 0.0 * wrap)


def _ends_d2(side: Array, d1: Array, d2: Array, arm: Arm) -> Array:
    r = arm.r
    t = np.sqrt(side**2 - r**2)
    return d2 * t / side + d1**2 * r**2 / (side**2 * t)


def _passes(side: Array, d1: Array, arm: Arm, alpha: Array, sign: float) -> Portion:
    """(25): along a side and on upwards, with the full turn on the upper pulley."""
    wrap = 2 * np.pi + sign * alpha
    return Portion(side + arm.r * wrap, d1 + sign * arm.r, wrap, 1.5 * np.pi + sign * alpha / 2)


def _strut(arm: Arm, alpha: Array, s: Sides, sign: float) -> Portion:
    """(30) with acos for A3 and A5 (the tangents beside them need it); sign +1, and -1 of the mirrored strut.

    Its length is even in alpha. Two of its three pulleys are on the upper bar: what is wound around them slides as the cable above.
    """
    r = arm.r
    lean = np.arctan2(s.d, arm.b * np.cos(alpha / 2))
    a3, a5 = np.arccos(2 * r / arm.L), np.arccos(2 * r / arm.b)
    straight = 2 * np.sqrt((arm.L / 2) ** 2 - r**2) + 2 * np.sqrt((arm.b / 2) ** 2 - r**2)
    # 2 psi - alpha = 2 (pi - lean)
    wrap = 4 * np.pi - 2 * lean - 2 * a3 - 2 * a5
    above = 2.5 * np.pi - lean - sign * alpha / 2 - a3 - 2 * a5
    return Portion(straight + r * wrap, _strut_d1(arm, alpha, s), wrap, above)


def _strut_d1(arm: Arm, alpha: Array, s: Sides) -> Array:
    return -arm.r * arm.b * np.sin(alpha / 2) / s.d


def _strut_d2(arm: Arm, alpha: Array, s: Sides) -> Array:
    return -arm.r * arm.b * np.cos(alpha / 2) / (2 * s.d) - _strut_d1(arm, alpha, s) * s.d1 / s.d


_PORTION = {
    "left": lambda arm, alpha, s: _ends(s.left, s.left1, arm, alpha, -1.0),
    "right": lambda arm, alpha, s: _ends(s.right, s.right1, arm, alpha, 1.0),
    "left_through": lambda arm, alpha, s: _passes(s.left, s.left1, arm, alpha, -1.0),
    "right_through": lambda arm, alpha, s: _passes(s.right, s.right1, arm, alpha, 1.0),
    "strut": lambda arm, alpha, s: _strut(arm, alpha, s, 1.0),
    "strut_mirrored": lambda arm, alpha, s: _strut(arm, alpha, s, -1.0),
}

_SECOND_DERIVATIVE = {
    "left": lambda arm, alpha, s: _ends_d2(s.left, s.left1, s.left2, arm),
    "right": lambda arm, alpha, s: _ends_d2(s.right, s.right1, s.right2, arm),
    "left_through": lambda arm, alpha, s: s.left2,
    "right_through": lambda arm, alpha, s: s.right2,
    "strut": _strut_d2,
    "strut_mirrored": _strut_d2,
}
"""of a portion's length by alpha"""
