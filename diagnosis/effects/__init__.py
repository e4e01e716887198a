"""What may be wrong with the model, one cause a file; `EFFECTS` lists them by name."""

from diagnosis.effect import Effect
from diagnosis.effects.actuator_gain import ActuatorGain
from diagnosis.effects.actuator_lag import ActuatorLag
from diagnosis.effects.actuator_offset import ActuatorOffset
from diagnosis.effects.backlash import Backlash
from diagnosis.effects.base_tilt import BaseTilt
from diagnosis.effects.cable_creep import CableCreep
from diagnosis.effects.cable_hardening import CableHardening
from diagnosis.effects.cable_hysteresis import CableHysteresis
from diagnosis.effects.cable_slack import CableSlack
from diagnosis.effects.clock_offset import ClockOffset
from diagnosis.effects.drum_radius import DrumRadius
from diagnosis.effects.joint_friction import JointFriction
from diagnosis.effects.marker_offset import MarkerOffset
from diagnosis.effects.pulley_friction import PulleyFriction
from diagnosis.effects.pulley_radius import PulleyRadius
from diagnosis.effects.spring_stiffness import SpringStiffness
from diagnosis.effects.stribeck_friction import StribeckFriction
from diagnosis.effects.tip_payload import TipPayload
from diagnosis.effects.viscous_friction import ViscousFriction

__all__ = ["EFFECTS"]

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        CableHardening(),
        StribeckFriction(),
        ViscousFriction(),
        PulleyFriction(),
        Backlash(),
        BaseTilt(),
        TipPayload(),
        PulleyRadius(),
        DrumRadius(),
        MarkerOffset(),
        JointFriction(),
        SpringStiffness(),
        ActuatorGain(),
        ActuatorOffset(),
        ActuatorLag(),
        CableCreep(),
        CableHysteresis(),
        CableSlack(),
        ClockOffset(),
    )
}
