"""What to do next: how to go on with a cause, what tells look-alikes apart, what to record where nothing could be told."""

from collections.abc import Sequence
from dataclasses import dataclass

from diagnosis.diagnose import Diagnosis
from diagnosis.effect import Effect, OfLaw
from diagnosis.effects import EFFECTS
from identification.identifiability import WANTED

_MEASURED = {
    "base_tilt": "put a spirit level on the base, or turn the base by a known angle and record again",
    "tip_payload": "weigh what sits at the tip, or record again with a known weight on it",
    "pulley_radius": "measure the pulleys, and bend every joint as far as it goes",
    "drum_radius": "measure the drum, and wind every cable far in and out",
    "marker_offset": "hold each joint at a known angle and compare, or put the markers on anew",
    "spring_stiffness": "measure the springs, and hold every joint bent by different angles",
    "clock_offset": "show the camera a light that the controller switches",
}
"""of effects that no design names: what settles them"""
_SIGNS = {
    "periodic": "look for teeth, poles or a bent shaft that come round as often as this; a slow motion over more of the drum's "
    "turn shows them more clearly",
    "drift": "let the arm run warm before recording, or record until nothing changes any more, and diagnose again",
    "episodes": "look at the video at these times: something touched or caught the arm; leave these times out, and diagnose again",
    "constant": "look for a load, a spring or an offset that neck.yaml does not know",
}
_RECORD = "xneck design neck.yaml --model model.yaml --out motion.csv"


@dataclass(frozen=True)
class Step:
    """In words, and the command where there is one."""

    words: str
    command: str = ""

    def as_json(self) -> dict[str, str]:
        """For the record."""
        return {"words": self.words, "command": self.command}


def advice(d: Diagnosis) -> tuple[Step, ...]:
    """By the verdict."""
    if d.verdict in ("cause", "ambiguous") or d.search.named:
        alike = {c.effect.name: c.effect for named in d.search.named if len(named.tied) > 1 for c in named.tied}
        return (*_apart(tuple(alike.values())), *_onwards())
    if d.verdict == "unknown":
        found = _SIGNS.get(
            d.signature.kind, "look at the equations and conditions shown above: there something acts that is not known"
        )
        return (
            Step(found),
            Step("compare with a recording of the same motion on another day: what comes back belongs to the arm"),
        )
    if d.sight.blind:
        return _shown(d.sight.blind)
    return (Step("nothing: the model may be used as it is"),)


def _apart(effects: Sequence[Effect]) -> tuple[Step, ...]:
    """What tells effects apart."""
    if not effects:
        return ()
    laws = [e.law for e in effects if isinstance(e, OfLaw)]
    steps = [Step(f"for {e.name.replace('_', ' ')}: {would_tell(e)}") for e in effects]
    if laws:
        wanted = " ".join(f"--for {law}" for law in laws)
        steps.append(Step("play a motion made to tell them, and diagnose its recording", _with(wanted)))
    return tuple(steps)


def _onwards() -> tuple[Step, ...]:
    return (
        Step(
            "the extended model stands in neck.yaml and model.yaml beside this page; read the recording anew with this description",
            "xneck sync ANGLES LOG --neck neck.yaml --out extended.mcap",
        ),
        Step("and simulate it", "xneck simulate extended.mcap --model model.yaml --out simulated.mcap"),
    )


def _shown(blind: Sequence[str]) -> tuple[Step, ...]:
    effects = [EFFECTS[name] for name in blind]
    told = list(dict.fromkeys(would_tell(e) for e in effects))
    laws = [e.law for e in effects if isinstance(e, OfLaw)]
    steps = [Step(f"to see {', '.join(name.replace('_', ' ') for name in blind)}: {'; '.join(told)}")]
    if laws:
        steps.append(Step("a motion made for it", _with(" ".join(f"--for {law}" for law in laws))))
    return tuple(steps)


def _with(wanted: str) -> str:
    return _RECORD.replace(" --out", f" {wanted} --out")


def would_tell(effect: Effect) -> str:
    """What to record or to measure."""
    return _MEASURED[effect.name] if effect.name in _MEASURED else WANTED[effect.terms[0].name]
