"""What is kept of a diagnosis: its verdict, and residuals over what noise alone leaves."""

from typing import Any

from diagnosis.diagnose import Diagnosis
from diagnosis.held_out_gain import EQUATIONS
from diagnosis.record import probability


def verdict_record(found: Diagnosis) -> dict[str, Any]:
    """Verdict, names of the causes, and residuals over the noise floor: fitted by channel, held out by equation."""
    motors = found.extended.arm.M
    held_out = {g.measure: [g.before / g.noise_floor, g.after / g.noise_floor] for g in found.gains}
    return {
        "verdict": found.verdict,
        "why": found.why,
        "causes": [cause.effect.name for cause in found.causes],
        "found_laws": [law.law.as_json() for law in found.found_laws],
        "probabilities": [probability(named) for named in found.search.named],
        "sets": [sorted({rival.effect.name for rival in named.tied}) for named in found.search.named],
        "motors_over_floor": found.before.ratio[:motors].tolist(),
        "joints_over_floor": found.before.ratio[motors:].tolist(),
        "over_floor_with_causes": found.after.ratio.tolist(),
        "held_out_over_floor": {measure: held_out.get(measure) for measure in EQUATIONS},
    }
