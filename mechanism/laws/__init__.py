"""What a machine of this kind may do, one law a file: friction of its motors, elasticity of its cables, resistance of its joints.

One definition serves simulation, identification and diagnosis. `LAWS` holds every law that a module of this folder defines, by
name; which of them act, and in which order, is for each machine to say.
"""

from mechanism.laws.law import CableMotion, JointMotion, Law, MotorMotion, Sliding, Term, Values
from mechanism.laws.unlisted import UnlistedLaw, unlisted_laws
from xneck_foundation.class_discovery import classes_in

__all__ = [
    "LAWS",
    "CableMotion",
    "JointMotion",
    "Law",
    "MotorMotion",
    "Sliding",
    "Term",
    "Values",
    "is_law",
    "law_named",
]

LAWS: dict[str, Law] = {law.name: law() for law in classes_in(__name__, __path__, Law) if law is not UnlistedLaw}


def is_law(name: str) -> bool:
    """Whether there is a law of this name, listed or not."""
    return name in LAWS or name in unlisted_laws()


def law_named(name: str) -> Law:
    """The law of a name, of `LAWS` or of those that no catalogue lists."""
    return LAWS[name] if name in LAWS else unlisted_laws()[name]
