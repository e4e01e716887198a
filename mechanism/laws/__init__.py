"""What a machine of this kind may do, one law a file: friction of its motors, elasticity of its cables, resistance of its joints.

One definition serves simulation, identification and diagnosis. `LAWS` holds every law that a module of this folder defines, by
name; which of them act, and in which order, is for each machine to say.
"""

from mechanism.laws.law import CableMotion, Law, MotorMotion, Term, Values
from xneck_foundation.class_discovery import classes_in

__all__ = ["LAWS", "CableMotion", "Law", "MotorMotion", "Term", "Values"]

LAWS: dict[str, Law] = {law.name: law() for law in classes_in(__name__, __path__, Law)}
