"""Whether a model belongs to the description that it is used with."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from identification.dataset.dataset import DataSet
from identification.model_file import Model
from mechanism.description import Neck
from xneck_foundation.recovery import warn_recovered


def warn_of_another_arm(model: Model, model_file: Path, neck: Neck, described_in: Path) -> None:
    """Warns where the description in a file is not that which the model was calibrated with."""
    if model.is_of_another_arm(neck):
        warn_recovered(
            described_in,
            f"describes another arm than the one that {model_file} was calibrated with; `diagnose` writes the neck.yaml of its "
            "model beside it: go on with that one",
        )


def of_the_models_arm(parts: Iterable[DataSet], model: Model, model_file: Path, data_set: Path) -> Iterator[DataSet]:
    """The parts of a data set, with that warning where they are of another arm."""
    for number, part in enumerate(parts):
        if number == 0:
            warn_of_another_arm(model, model_file, part.neck, data_set)
        yield part
