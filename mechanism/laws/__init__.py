"""What a machine of this kind may do, one law a file: friction of its motors, elasticity of its cables, resistance of its joints.

One definition serves simulation, identification and diagnosis: `LAWS` lists them by name.
"""

from mechanism.laws.actuator_gain import ActuatorGain
from mechanism.laws.actuator_lag import ActuatorLag
from mechanism.laws.actuator_offset import ActuatorOffset
from mechanism.laws.backlash import Backlash
from mechanism.laws.creep import Creep
from mechanism.laws.dry_friction import DryFriction
from mechanism.laws.hardening import Hardening
from mechanism.laws.hysteresis import Hysteresis
from mechanism.laws.joint_friction import JointFriction
from mechanism.laws.law import Law, Stretching, Term, Turning, Values
from mechanism.laws.linear_cable import LinearCable
from mechanism.laws.pulley_friction import PulleyFriction
from mechanism.laws.slack import Slack
from mechanism.laws.stribeck import Stribeck
from mechanism.laws.toe import Toe
from mechanism.laws.viscous_friction import ViscousFriction
from mechanism.laws.youngs_modulus import YoungsModulus, YoungsModulusInPose

__all__ = ["LAWS", "Law", "Stretching", "Term", "Turning", "Values"]

LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        DryFriction(),
        ViscousFriction(),
        Stribeck(),
        PulleyFriction(),
        LinearCable(),
        YoungsModulus(),
        YoungsModulusInPose(),
        Hardening(),
        Toe(),
        Creep(),
        Hysteresis(),
        JointFriction(),
        ActuatorGain(),
        ActuatorOffset(),
        ActuatorLag(),
        Backlash(),
        Slack(),
    )
}
