"""What may be wrong with the model, one cause a file; `EFFECTS` lists them by name."""

from identification.diagnosis.effect import Effect
from identification.diagnosis.effects.actuator_gain import ActuatorGain
from identification.diagnosis.effects.actuator_lag import ActuatorLag
from identification.diagnosis.effects.actuator_offset import ActuatorOffset
from identification.diagnosis.effects.backlash import Backlash
from identification.diagnosis.effects.base_tilt import BaseTilt
from identification.diagnosis.effects.cable_creep import CableCreep
from identification.diagnosis.effects.cable_hardening import CableHardening
from identification.diagnosis.effects.cable_hysteresis import CableHysteresis
from identification.diagnosis.effects.cable_slack import CableSlack
from identification.diagnosis.effects.clock_offset import ClockOffset
from identification.diagnosis.effects.drum_radius import DrumRadius
from identification.diagnosis.effects.joint_friction import JointFriction
from identification.diagnosis.effects.marker_offset import MarkerOffset
from identification.diagnosis.effects.pulley_friction import PulleyFriction
from identification.diagnosis.effects.pulley_radius import PulleyRadius
from identification.diagnosis.effects.spring_stiffness import SpringStiffness
from identification.diagnosis.effects.stribeck_friction import StribeckFriction
from identification.diagnosis.effects.tip_payload import TipPayload
from identification.diagnosis.effects.viscous_friction import ViscousFriction

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
