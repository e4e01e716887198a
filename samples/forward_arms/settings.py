"""What arms, motions, clocks and angles are drawn from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from samples.forward_arms.laws import Law

Range = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """One setting for all arms of a call; ranges are (least, greatest), drawn anew for each arm or recording."""

    mechanisms: int = 3
    unlike: bool = False
    """mechanisms of one arm are drawn each by itself"""
    unlike_motors: bool = False
    """motors of one arm have gears, drums and inertias of their own"""
    routes: tuple[tuple[str, ...], ...] | None = None
    """of the cables; None: mechanism by mechanism on the right over struts, and one on the left through all"""
    base: Literal["presliding", "near", "almost", "exact"] = "presliding"
    """dry friction: LuGre bristles without Stribeck's peak (up to 3-5 N rms from the arctangent, rests counted), a hyperbola with
    the arctangent's tail (0.4-0.7 N rms), a tenth of the way from the arctangent to that (0.04-0.07 N rms), or exactly
    fs (2/pi) atan(0.5 theta')"""
    presliding: Range = (0.02, 0.1)
    """rad of the motor, over which bristles bend"""
    stiffness: Range = (5000.0, 10500.0)
    """N/m"""
    damping: Range = (20.0, 800.0)
    """N s/m, evenly in its logarithm"""
    dry_friction: Range = (10.0, 19.0)
    """N"""
    viscous_friction: Range = (0.0, 0.0)
    """N s/rad"""
    motor_inertia: Range = (3e-6, 6e-6)
    """kg m^2"""
    counts: int = 2048
    drawing_off: float = 0.0
    """how far true numbers are from the drawing, in standard deviations of a workshop (samples.forward_arms.drawing)"""
    laws: Callable[[int], Sequence[Law]] | None = None
    """hidden effects of the arm of a seed"""

    seconds: float = 60.0
    recordings: int = 2
    first_recording: int = 0
    """number of the first: others of the same arm have another motion, other clocks and other noise"""
    motion: Literal["rich", "slow"] = "rich"
    motion_of: Literal["joints", "tensions"] = "joints"
    """what is asked of the arm: angles of its joints, or tensions of its cables (for arms with too few cables for any angles)"""
    peak_deg: Range = (25.0, 40.0)
    joint_shares: tuple[float, ...] | None = None
    """of its peak, that each joint is asked to move; None: all of it"""
    motor_speed: float = 150.0
    """rad/s, the fastest that is asked of a motor: faster motions are slowed down"""
    tension: Literal["rich", "constant"] = "rich"
    tension_range: Range = (12.0, 150.0)
    """N, that the controller asks of a cable"""
    pretension: Range = (25.0, 60.0)
    """N, what tensions go about"""
    friction_compensation: float = 0.8
    """share of the dry friction that the controller feeds forward"""
    delay: float = 0.0
    """s, from a row of the log to its force"""
    jitter: float = 0.0
    """s, standard deviation of that delay from row to row"""
    step: float = 5e-4
    """s, of the integration; divides the controller's 2 ms"""

    camera_rate: float = 30.0
    exposure: Range = (0.004, 0.012)
    """s"""
    noise_deg: float = 0.02
    sigma_columns: bool = False
    dropped: float = 0.01
    """share of the frames"""
    offset: Range = (-0.9, 0.9)
    """s, log time at camera time 0"""
    skew_ppm: Range = (-40.0, 40.0)

    columns: int = 128
    """recordings that are integrated together"""
