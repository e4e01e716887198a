"""Whether the identified model explains a recording, by how far its simulation is off, in times of what noise alone would make."""

from dataclasses import asdict, dataclass
from typing import Any

from identification.simulation.simulated_recording import SimulatedRecording
from xneck.report.number_text import number_text
from xneck.report.recorded_channel import channel_words

UNEXPLAINED_RATIO = 3.0
"""times noise from which on the page says that the model does not explain the arm, where a true model would stay below
(docs/thresholds.md)"""
DIAGNOSE_COMMAND = "xneck diagnose dataset.mcap --held-out ../OTHER/dataset.mcap --out ../diagnosis"
"""to be typed in the folder of the page"""


@dataclass(frozen=True)
class ModelAdequacy:
    """How a simulation's worst channel stands to noise."""

    ratio: float
    """its error over what noise would make"""
    ratio_95: float
    """ratio that a true model exceeds in 5 of 100 recordings"""
    channel: str
    """in words"""

    @property
    def explains(self) -> bool:
        """Whether noise may explain the error."""
        return self.ratio <= max(UNEXPLAINED_RATIO, self.ratio_95)

    @property
    def sentence(self) -> str:
        """The same in words."""
        below = number_text(self.ratio_95, 2)
        if self.explains:
            return (
                f"The model explains this arm: it simulates at {number_text(self.ratio, 2)} times noise at most "
                f"({self.channel}; a true model stays below {below} in 95 of 100 recordings)."
            )
        return (
            f"The model does not explain this arm as it is drawn: it simulates {self.channel} at {number_text(self.ratio, 3)} "
            f"times noise, where a true model stays below {below}. That may be a drawing off within its tolerance, or a cause: "
            "a diagnosis tells them apart."
        )

    def as_json(self) -> dict[str, Any]:
        """The same, ready for JSON."""
        return {"explains": self.explains, **asdict(self), "sentence": self.sentence}


def model_adequacy(simulated: SimulatedRecording | None) -> ModelAdequacy | None:
    """By the channel that stands furthest above what a true model would make of it; None where nothing could be simulated."""
    if simulated is None or not simulated.channels:
        return None
    worst = max(simulated.channels, key=lambda channel: channel.ratio / channel.ratio_95)
    return ModelAdequacy(worst.ratio, worst.ratio_95, channel_words(worst.name))
