"""A designed motion as the controller's table, as JSON and as text."""

import math
from typing import Any

from identification.dataset.series import Series, numbered_columns
from identification.design.information import AngleNoise
from identification.design.search import DesignedMotion
from identification.design.trajectory import MotionLimits, Trajectory
from identification.identifiability import term_label
from xneck_foundation.unit_text import with_unit


def motion_series(motion: Trajectory) -> Series:
    """Columns time, alphaI, thetaJ, fJ, as a controller plays them, and the cables' tensions tensionJ, N."""
    return Series(
        motion.time,
        numbered_columns("alpha", motion.alpha)
        | numbered_columns("theta", motion.theta)
        | numbered_columns("f", motion.f)
        | numbered_columns("tension", motion.tension),
    )


def as_json(design: DesignedMotion, limits: MotionLimits, noise: AngleNoise) -> dict[str, Any]:
    """Predicted sigmas, limits, and how far they are reached."""
    u, p = design.target.unknowns, design.target.p
    return {
        "parameters": [
            {
                "name": e.term.name,
                "index": e.index,
                "value": float(p[i]),
                "unit": e.term.unit,
                "sigma": float(design.sigma[i]),
                "relative_sigma_percent": float(100 * design.sigma[i] / abs(p[i])) if p[i] else None,
                "for": bool(i in design.target.chosen),
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
        "reached": design.motion.reached(),
        "start": {"theta_rad": design.motion.theta[0].tolist(), "tension_N": design.motion.tension[0].tolist()},
        "seconds": float(design.motion.time[-1]),
    }


def as_text(design: DesignedMotion) -> str:
    """Predicted sigmas of the target parameters, and how far limits are reached."""
    u, p, reached = design.target.unknowns, design.target.p, design.motion.reached()
    lines = []
    for i in design.target.chosen:
        e = u.entries[i]
        share = f" ({100 * design.sigma[i] / abs(p[i]):.2g} %)" if p[i] else ""
        lines.append(with_unit(f"  {term_label(e):8} {p[i]:10.6g} +- {design.sigma[i]:.2g}", e.term.unit) + share)
    angles = ", ".join(f"{math.degrees(a):.1f}" for a in reached["alpha_rad"])  # type: ignore[union-attr]
    lines.append(
        f"  angles up to {angles} deg, motors {reached['motor_speed_rad_s']:.0f} rad/s, "
        f"tensions {reached['tension_min_N']:.0f} to {reached['tension_max_N']:.0f} N, forces {reached['force_max_N']:.0f} N"
    )
    start = ", ".join(f"{t:.2f}" for t in design.motion.theta[0])
    lines.append(f"  begins and ends straight and still, with theta at {start} rad")
    return "\n".join(lines)
