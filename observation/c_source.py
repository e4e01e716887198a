"""The observer of one arm and model as one C99 file without dependencies: the same equations, the same filter, the same numbers.

observer.c.in is that file without what differs from arm to arm: sizes, numbers, and the equations of motion.
"""

from collections.abc import Mapping, Sequence
from importlib.resources import files

import numpy as np

from mechanism.friction import HELD_VARIANCE
from mechanism.laws import Law
from observation.expression import Expression, variable
from observation.frame_correction import FORGOTTEN_S, PASSING_SHARE, TURNING_RAD_S
from observation.generated_code import c_function
from observation.observer import MAX_STEP_S, SPEED_SIGMAS, Observer
from observation.pose_error import ELONGATION_D_M_S, SPEED_RAD_S
from observation.pose_time import POSE_TIME_S
from observation.prediction import GAMMA
from observation.recent_motion import SIDE_TRAVEL_M
from observation.start_at_rest import AT_REST_RAD, MAX_NEWTON_RAD, NEWTON_STEPS, RANGE_RAD
from observation.tracing import Untraceable, elements_of, symbols
from xneck_foundation.errors import Refused

_TEMPLATE = "observer.c.in"
_LARGEST = 1e300
"""in the place of infinity, which C99 has no constant of that all compilers take"""


def c_source(observer: Observer) -> str:
    """The file's text. Raises Refused where a law cannot be written in C, with its name."""
    laws = [law for law in observer.numbers.machine.laws if type(law).acting_force is not Law.acting_force]
    parts = {
        "DEFINES": "\n".join(f"#define {name} {value!r}" for name, value in _defines(observer, len(laws)).items()),
        "CONSTANTS": _constants(observer),
        "EQUATIONS": "\n".join([_equations(observer), _acting_forces(observer, laws)]),
    }
    text = files("observation").joinpath(_TEMPLATE).read_text(encoding="utf-8")
    for name, part in parts.items():
        text = text.replace(f"@{name}@", part)
    return text


def _defines(observer: Observer, law_count: int) -> dict[str, int | float]:
    """Sizes, places in the state, and constants of the filter by the names that the C file has for them."""
    e, layout, factor = observer.equations, observer.numbers.layout, observer.numbers.pose_error.factor
    return {
        "N_": layout.N,
        "M_": layout.M,
        "S_": layout.S,
        "SIZE": layout.size,
        "RATES": len(e.rates),
        "DERIVATIVES": len(e.derivatives),
        "FEATURES": factor.shape[0],
        "RANK": factor.shape[2],
        "LAWS": law_count,
        "AT_THETA": layout.theta.start,
        "AT_X0": layout.x0.start,
        "KEPT": layout.dragged.stop - layout.x0.start,
        "AT_SIDES": int(layout.sides[0]) if len(layout.sides) else 0,
        "AT_POSE": layout.pose_error.start,
        "GAMMA": float(GAMMA),
        "HELD_VARIANCE": HELD_VARIANCE,
        "POSE_TIME_S": POSE_TIME_S,
        "TURNING_RAD_S": TURNING_RAD_S,
        "PASSING_SHARE": PASSING_SHARE,
        "FORGOTTEN_S": FORGOTTEN_S,
        "SIDE_TRAVEL_M": SIDE_TRAVEL_M,
        "LET_GO_RATE": observer.numbers.let_go_rate,
        "SPEED_RAD_S": SPEED_RAD_S,
        "ELONGATION_D_M_S": ELONGATION_D_M_S,
        "SPEED_SIGMAS": SPEED_SIGMAS,
        "MAX_STEP_S": MAX_STEP_S,
        "MISSING_S": observer.missing_s,
        "MAX_GAP_S": observer.gap_s,
        "NEWTON_STEPS": NEWTON_STEPS,
        "MAX_NEWTON_RAD": MAX_NEWTON_RAD,
        "AT_REST_RAD": AT_REST_RAD,
        "RANGE_RAD": RANGE_RAD,
    }


def _constants(observer: Observer) -> str:
    """Definitions of the filter's arrays."""
    numbers, error, size = observer.numbers, observer.numbers.pose_error, observer.numbers.layout.size
    arrays = {
        "start_state": numbers.start,
        "start_sigma": numbers.start_sigma,
        "noise": numbers.noise,
        "decay": numbers.decay,
        "theta_sigma": numbers.theta_sigma,
        # one more than there are: C has no arrays without an entry
        "memory_bound": np.minimum(np.append(numbers.memory_bound, 0.0), _LARGEST),
        "drum": numbers.machine.arm.drum,
        "pose_middle": error.middle,
        "pose_half_range": error.half_range,
        "pose_tension": np.array(error.tension),
        "marker_offset": numbers.marker_offset,
        "pose_floor": numbers.pose_floor,
        "learned_variance": numbers.no_correction.unknown.ravel(),
        "pose_slope": numbers.pose_slope,
        "pose_rate": numbers.pose_rate,
        "pose_factor": error.factor.ravel(),
    }
    lines = [
        f"static const double {name}[] = {{{', '.join(repr(float(v)) for v in values)}}};"
        for name, values in arrays.items()
    ]
    places = ", ".join(str(row * size + column) for row, column in observer.equations.places)
    return "\n".join([*lines, f"static const int place[] = {{{places}}};"])


def _equations(observer: Observer) -> str:
    """The C function of the equations of motion with their derivatives."""
    e = observer.equations
    return c_function(
        "equations",
        {"state": [v.name for v in e.state], "force": [v.name for v in e.force], "since": [e.time.name]},
        {
            "mass": e.mass,
            "rates": e.rates,
            "derivatives": e.derivatives,
            "tension": e.tension,
            "elongation_d": e.elongation_d,
            "held": e.held,
        },
    )


def _acting_forces(observer: Observer, laws: Sequence[Law]) -> str:
    """C functions of the force that acts in the first row and in any later one, by the laws of the actuators."""
    machine, m = observer.numbers.machine, observer.numbers.layout.M
    told = [variable(f"told{j}") for j in range(m)]
    before_names = [[f"b{k}_{j}" for j in range(m)] for k in range(len(laws))]
    inputs = {"f": [v.name for v in told], "before": [name for own in before_names for name in own]}
    texts: list[str] = []
    for function, is_first in (("first_acting", True), ("next_acting", False)):
        f = symbols(np.array(told, dtype=object))
        after: list[Expression] = []
        for law, names in zip(laws, before_names, strict=True):
            before = None if is_first else symbols(np.array([variable(v) for v in names], dtype=object))
            try:
                f = law.next_force(machine.values, f, before, observer.step_s)
            except Untraceable as error:
                raise Refused("observe", f"the law {law.name} cannot be written in C ({error})") from error
            after += list(elements_of(f).ravel())
        outputs: Mapping[str, list[Expression]] = {"acting": list(elements_of(f).ravel()), "after": after}
        texts.append(c_function(function, inputs, outputs))
    return "\n".join(texts)
