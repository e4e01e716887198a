"""A designed motion as the controller's table, and what is said of it."""

import math
from typing import Any

from identification.dataset.series import Series, numbered_columns
from identification.design.information import AngleNoise
from identification.design.search import DesignedMotion
from identification.design.trajectory import MotionLimits, Trajectory
from identification.identifiability import term_label


def motion_series(motion: Trajectory) -> Series:
    """time, alphaI, thetaJ, fJ."""
    return Series(
        motion.time, numbered_columns("alpha", motion.alpha) | numbered_columns("theta", motion.theta) | numbered_columns("f", motion.f)
    )


def as_json(found: DesignedMotion, limits: MotionLimits, noise: AngleNoise) -> dict[str, Any]:
    """Predicted sigmas, limits and how far they are reached."""
    u, p = found.wanted.unknowns, found.wanted.p
    return {
        "parameters": [
            {
                "name": e.term.name,
                "index": e.index,
                "value": float(p[i]),
                "unit": e.term.unit,
                "sigma": float(found.sigma[i]),
                "relative_sigma_percent": float(100 * found.sigma[i] / abs(p[i])) if p[i] else None,
                "for": bool(i in found.wanted.chosen),
            }
            for i, e in enumerate(u.entries)
            if e.recording is None
        ],
        "noise": {"sigma_alpha_rad": noise.sigma, "frame_hz": noise.frame_hz},
        "limits": {
            "alpha_rad": limits.peak,
            "motor_speed_rad_s": limits.speed,
            "tension_N": list(limits.tension),
            "force_N": limits.force if math.isfinite(limits.force) else None,
        },
        "reached": found.motion.reached(),
        "start": {"theta_rad": found.motion.theta[0].tolist(), "tension_N": found.motion.tension[0].tolist()},
        "seconds": float(found.motion.time[-1]),
    }


def as_text(found: DesignedMotion) -> str:
    """The sigmas of what was asked for, and the limits reached."""
    u, p, reached = found.wanted.unknowns, found.wanted.p, found.motion.reached()
    lines = []
    for i in found.wanted.chosen:
        e = u.entries[i]
        share = f" ({100 * found.sigma[i] / abs(p[i]):.2g} %)" if p[i] else ""
        lines.append(f"  {term_label(e):8} {p[i]:10.6g} +- {found.sigma[i]:.2g} {e.term.unit}{share}")
    angles = ", ".join(f"{math.degrees(a):.1f}" for a in reached["alpha_rad"])  # type: ignore[union-attr]
    lines.append(
        f"  angles up to {angles} deg, motors {reached['motor_speed_rad_s']:.0f} rad/s, "
        f"tensions {reached['tension_min_N']:.0f} to {reached['tension_max_N']:.0f} N, forces {reached['force_max_N']:.0f} N"
    )
    start = ", ".join(f"{t:.2f}" for t in found.motion.theta[0])
    lines.append(f"  begins and ends straight and still, with theta at {start} rad")
    return "\n".join(lines)
