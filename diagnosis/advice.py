"""What to do next: how to go on with a cause, what tells look-alikes apart, what to record where nothing could be told."""

from collections.abc import Sequence
from dataclasses import dataclass

from diagnosis.diagnose import Diagnosis, unlisted_law
from diagnosis.effect import Effect
from diagnosis.effects import EFFECTS
from diagnosis.unlisted_laws import AGAINST_SEVERAL_JOINTS, OF_ENCODERS
from discovery.problem import Candidate

_TOUCHED = "look at the video at these times: something touched or caught the arm"
_BY_SIGNATURE = {
    "periodic": "look for teeth, poles or a bent shaft that come round as often as this; a slow motion over more of the drum's "
    "turn shows them more clearly",
    "drift": "let the arm run warm before recording, or record until nothing changes any more, and diagnose again",
    "episodes": _TOUCHED,
    "constant": "look for a load, a spring or an offset that neck.yaml does not know",
}
"""what to look for, by the kind of a signature"""
BY_VARIABLE = {
    "force": "measure what force arrives when much is commanded: motors saturate, and gears rub by their load",
    "tension": "look for what cables rub on, and at the drums' bearings",
    "motor's turn": "look for teeth, poles or a bent shaft that come round with the motor",
    "drum's turn": "look for a drum that is not round, or rope that climbs on itself",
    "motor's speed": "look for friction that is neither dry nor viscous",
    "time": _BY_SIGNATURE["drift"],
    "joint's angle": "look for a hose, a wire or a stop against which the joint bends",
    "joint's speed": "look for a damper, or for air that is moved",
}
"""what to look for, by the variable that the rest follows"""
_WORDS_OF_VARIABLES = {
    "force": "force",
    "tension": "tension",
    "motor_angle": "motor's turn",
    "drum_angle": "drum's turn",
    "motor_speed": "motor's speed",
    "time": "time",
    "joint_angle": "joint's angle",
    "joint_speed": "joint's speed",
}
"""as laws have them"""
_BY_EQUATION = {
    OF_ENCODERS: "look at how the encoder sits on its shaft: a disc or a magnet beside the axis reads so, once or twice a turn",
    AGAINST_SEVERAL_JOINTS: "look for a hose, a loom of leads or a band that is fixed below and above these joints",
}
"""what to look for, by where a law acts"""
_BY_OTHER_SIGNATURES = "look at the equations and conditions shown above: there something acts that is not known"
_PLAY = (
    "play motion.csv, which was made for this question within the limits of an arm like Fasquelle's, and diagnose its recording "
    "together with these; this command makes one within limits of your own"
)
_DESIGN = "xneck design neck.yaml --model model.yaml {} --out motion.csv"


@dataclass(frozen=True)
class Step:
    """In words, and the command where there is one."""

    words: str
    command: str = ""

    def as_json(self) -> dict[str, str]:
        """For the record."""
        return {"words": self.words, "command": self.command}


_EXTENDED = "the extended model stands in neck.yaml and model.yaml beside this page"
_EXTRACT = "xneck extract VIDEO --camera camera.yaml --neck neck.yaml --out angles.mcap"
_SYNC = "xneck sync ANGLES LOG --neck neck.yaml --out extended.mcap"
_SIMULATE = Step("and simulate it", "xneck simulate extended.mcap --model model.yaml --out simulated.mcap")
_READ_ANEW = (Step(f"{_EXTENDED}; read the recording anew with this description", _SYNC),)
_EXTRACT_ANEW = (
    Step(f"{_EXTENDED}; extract the angles of a video anew with this description", _EXTRACT),
    Step("read the recording with it", _SYNC),
)


def advice(d: Diagnosis) -> tuple[Step, ...]:
    """By the verdict."""
    if d.verdict in ("cause", "ambiguous") or d.search.named:
        look_alikes = {c.effect.name: c.effect for named in d.search.named if len(named.tied) > 1 for c in named.tied}
        if not look_alikes and d.verdict == "insufficient":
            look_alikes = {named.effect.name: named.effect for named in d.search.named}
        touched = [Step(_TOUCHED)] if any(d.set_aside) else []
        return (*_tell_apart(tuple(look_alikes.values())), *touched, *_go_on(d))
    if d.verdict == "unknown":
        look_for = _BY_SIGNATURE.get(d.signature.kind, _BY_OTHER_SIGNATURES)
        if d.found_laws:
            look_for = look_for_law(d.found_laws[0].law.candidate)
        elif any(d.set_aside):
            look_for = _TOUCHED
        elif unlisted_law(d.search, ()) and d.search.unlisted:
            look_for = BY_VARIABLE[d.search.unlisted.function.variable.name]
        another_day = Step(
            "compare with a recording of the same motion on another day: what comes back belongs to the arm"
        )
        return (Step(look_for), another_day, *(_go_on(d) if d.found_laws else ()))
    if d.detectability.invisible:
        return _make_visible(d.detectability.invisible, d.verdict == "insufficient")
    return (Step("nothing: the model may be used as it is"),)


def _go_on(d: Diagnosis) -> tuple[Step, ...]:
    markers = d.extended_stage.hypothesis.neck.markers
    return (*(_READ_ANEW if markers is None else _EXTRACT_ANEW), _SIMULATE)


def look_for_law(candidate: Candidate) -> str:
    """What may act as a law that was found."""
    return _BY_EQUATION.get(candidate.detail) or BY_VARIABLE[_WORDS_OF_VARIABLES[candidate.follows[0]]]


def _tell_apart(effects: Sequence[Effect]) -> tuple[Step, ...]:
    """What tells effects apart."""
    if not effects:
        return ()
    steps = [Step(f"for {e.name.replace('_', ' ')}: {e.would_tell}") for e in effects]
    return (*steps, Step(_PLAY, _design_command(effects)))


def _make_visible(names: Sequence[str], motion_written: bool) -> tuple[Step, ...]:
    """What would show effects that these recordings do not; motion_written: whether a motion for it comes with the diagnosis."""
    effects = [EFFECTS[name] for name in names]
    would_tell = dict.fromkeys(e.would_tell for e in effects)
    return (
        Step(f"to see {', '.join(name.replace('_', ' ') for name in names)}: {'; '.join(would_tell)}"),
        Step(_PLAY if motion_written else "this command makes a motion for it", _design_command(effects)),
    )


def _design_command(effects: Sequence[Effect]) -> str:
    """The command that designs a motion for effects."""
    return _DESIGN.format(" ".join(f"--for {e.name}" for e in effects))
