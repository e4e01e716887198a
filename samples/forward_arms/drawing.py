"""Arms drawn at random, and how far an arm is from its drawing."""

from dataclasses import replace
from typing import Any

import numpy as np

from samples.forward_arms.cables import NONE, WORDS
from samples.forward_arms.plant import Array, Plant
from samples.forward_arms.settings import Range, Settings

GRAVITY = -9.81j

WORKSHOP = {
    "diagonal_mass": 0.03,
    "bar_mass": 0.03,
    "diagonal_inertia": 0.05,
    "bar_inertia": 0.05,
    "motor_inertia": 0.1,
    "spring_left": 0.05,
    "spring_right": 0.05,
    "free_left": 0.01,
    "free_right": 0.01,
    "L": 0.002,
    "b": 0.002,
    "r": 0.01,
    "drum": 0.002,
}
"""relative standard deviations of an arm from its drawing"""
HYPERBOLA = {"near": 1.0, "almost": 0.1}
"""share of a hyperbola in the dry friction, by the base"""
LEANING = np.radians(0.3)
"""rad, standard deviation of the base's tilt"""


def usual_routes(n: int) -> tuple[tuple[str, ...], ...]:
    """Mechanism by mechanism on the right over struts, and one cable on the left through all."""
    right = tuple(("strut",) * i + ("right",) for i in range(n))
    return (*right, ("left_through",) * (n - 1) + ("left",))


def drawn(settings: Settings, seed: int) -> Plant:
    """The arm of a seed as its drawing has it."""
    rng = np.random.default_rng([seed, 0])
    n = settings.mechanisms
    routes = settings.routes or usual_routes(n)
    m = len(routes)

    def joints(low: float, high: float) -> Array:
        return rng.uniform(low, high, n) if settings.unlike else np.full(n, rng.uniform(low, high))

    def cables(within: Range) -> Array:
        return rng.uniform(*within, m)

    def motors(low: float, high: float) -> Array:
        return rng.uniform(low, high, m) if settings.unlike_motors else np.full(m, rng.uniform(low, high))

    L = joints(0.08, 0.115)
    b = L * joints(0.47, 0.58)
    r = b * joints(0.09, 0.12)
    bar_mass, diagonal_mass = joints(0.03, 0.06), joints(0.02, 0.045)
    free = np.sqrt(L**2 - b**2) * joints(0.5, 0.7)
    # springs hold the column up against its own weight, the lower the more
    carried = np.cumsum((bar_mass + 2 * diagonal_mass)[::-1])[::-1]
    spring = joints(350.0, 550.0) * np.maximum(1.0, carried / 0.4)
    stiffness = cables(settings.stiffness)
    bristles = cables(settings.presliding)
    words = np.full((n, m), NONE, dtype=np.intp)
    for j, route in enumerate(routes):
        words[: len(route), j] = [WORDS.index(word) for word in route]
    return Plant(
        L=L,
        b=b,
        r=r,
        diagonal_mass=diagonal_mass,
        diagonal_inertia=diagonal_mass * L**2 / 12 * joints(0.9, 1.3),
        bar_mass=bar_mass,
        bar_inertia=bar_mass * b**2 / 12 * joints(0.9, 1.6),
        bar_com=np.zeros(n) + 1j * joints(-0.003, 0.003),
        spring_left=spring,
        spring_right=spring.copy(),
        free_left=free,
        free_right=free.copy(),
        gravity=np.array([GRAVITY]),
        routes=words,
        gear=motors(20.0, 32.0),
        drum=motors(0.0095, 0.0125),
        motor_inertia=motors(*settings.motor_inertia),
        dry=cables(settings.dry_friction),
        viscous=cables(settings.viscous_friction),
        presliding=bristles if settings.base == "presliding" else np.zeros(m),
        hyperbola=np.full(m, HYPERBOLA.get(settings.base, 0.0)),
        stiffness=stiffness,
        damping=np.exp(rng.uniform(np.log(settings.damping[0]), np.log(settings.damping[1]), m)),
        x0=rng.uniform(14.0, 20.0) * cables((0.85, 1.15)) / stiffness,
        counts=np.full(m, float(settings.counts)),
    )


def built(drawing: Plant, settings: Settings, seed: int) -> Plant:
    """The arm as a workshop makes it from its drawing."""
    if settings.drawing_off == 0:
        return drawing
    rng = np.random.default_rng([seed, 1])
    off = settings.drawing_off
    changed: dict[str, Any] = {}
    for name, sigma in WORKSHOP.items():
        value = getattr(drawing, name)
        changed[name] = value * (1 + off * sigma * rng.standard_normal(value.shape))
    changed["gravity"] = drawing.gravity * np.exp(-1j * off * LEANING * rng.standard_normal())
    return replace(drawing, **changed)


def neck(drawing: Plant) -> dict[str, Any]:
    """What neck.yaml says of the drawing."""
    d = drawing
    routes = [[WORDS[w] for w in column if w != NONE] for column in d.routes.T]
    return {
        "xneck": 1,
        "gravity": [float(d.gravity[0].real), float(d.gravity[0].imag)],
        "mechanisms": [
            {
                "L": float(d.L[i]),
                "b": float(d.b[i]),
                "r": float(d.r[i]),
                "diagonal": {"mass": float(d.diagonal_mass[i]), "inertia": float(d.diagonal_inertia[i])},
                "top": {
                    "mass": float(d.bar_mass[i]),
                    "inertia": float(d.bar_inertia[i]),
                    "com": [float(d.bar_com[i].real), float(d.bar_com[i].imag)],
                },
                "springs": {
                    "stiffness": float(d.spring_left[i]),
                    "free_length": float(d.free_left[i]),
                    "slack": False,
                },
            }
            for i in range(d.N)
        ],
        "cables": [{"route": r, "length": 0.3 + 0.3 * len(r), "section": 7.9e-7} for r in routes],
        "motors": [
            {
                "R": float(d.gear[j]),
                "rd": float(d.drum[j]),
                "Ia": float(d.motor_inertia[j]),
                "counts": int(d.counts[j]),
                "theta_sign": 1,
            }
            for j in range(d.M)
        ],
    }
