"""How well the numbers of a description are known."""

from math import degrees, pi, radians
from typing import Annotated

from pydantic import AfterValidator, Field

from xneck_foundation.strict_yaml import Strict

_MAX_ANGLE_RAD = 0.1
"""6 deg: no workshop is that far off, and 0.3 is what the manual's table has in degrees"""


def _in_radians(angle: float) -> float:
    """Raises ValueError, for validators, where an angle is likely in degrees."""
    if angle > _MAX_ANGLE_RAD:
        raise ValueError(
            f"{angle:g} rad are {degrees(angle):.3g} deg; if {angle:g} deg are meant, write {radians(angle):.3g}"
        )
    return angle


SmallAngle = Annotated[float, Field(ge=0), AfterValidator(_in_radians)]


class Tolerance(Strict):
    """How well the numbers of the description are known, one standard deviation each; unless said as a workshop keeps them.

    Relative to the number, but for `tilt` and `marker_angle`, rad.
    """

    mass: Annotated[float, Field(ge=0, le=1)] = 0.03
    """of every bar's mass, relative"""
    inertia: Annotated[float, Field(ge=0, le=1)] = 0.05
    """of every bar's inertia, relative"""
    motor_inertia: Annotated[float, Field(ge=0, le=1)] = 0.1
    """of every motor's Ia, relative"""
    stiffness: Annotated[float, Field(ge=0, le=1)] = 0.05
    """of every spring's stiffness by itself, relative"""
    free_length: Annotated[float, Field(ge=0, le=1)] = 0.01
    """of every spring's free_length by itself, relative"""
    length: Annotated[float, Field(ge=0, le=1)] = 0.002
    """of every mechanism's L and b, relative"""
    pulley: Annotated[float, Field(ge=0, le=1)] = 0.01
    """of every mechanism's r, relative"""
    drum: Annotated[float, Field(ge=0, le=1)] = 0.002
    """of every motor's rd, relative"""
    tilt: SmallAngle = 0.3 * pi / 180
    """rad, of the base against gravity"""
    marker_angle: SmallAngle = 0.3 * pi / 180
    """rad, of the markers of one bar together against it, or of an angle's zero"""
    friction_curve: Annotated[float, Field(ge=0, le=1)] = 0.01
    """of dry friction: by how much its curve over speed may differ from the arc tangent (48)"""


EXACT = Tolerance(**dict.fromkeys(Tolerance.model_fields, 0.0))
"""of a description that is right in every number"""
