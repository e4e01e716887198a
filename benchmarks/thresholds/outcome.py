"""What a verdict was worth against the truth."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    """right: as the truth has it. false: something is said that is not so. Neither: too little is said."""

    right: bool
    false: bool
    said: str
