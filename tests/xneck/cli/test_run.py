"""`xneck run`: which recording is held out, and what its table says of each model."""

from pathlib import Path

import pytest

from tests.command import run
from tests.paths import SAMPLES
from xneck.report.batch_table import COLUMNS, row_cells
from xneck.report.model_adequacy import ModelAdequacy, model_adequacy

BOTH = (SAMPLES / "recording", SAMPLES / "held_out")


@pytest.mark.parametrize(
    ("folders", "name", "said"),
    [
        (BOTH, "heldout", "--held-out: no recording is called 'heldout'; did you mean held_out?"),
        (BOTH, "day2", "--held-out: no recording is called 'day2'; valid: recording, held_out"),
        (BOTH[1:], "held_out", "--held-out: held_out is the only recording; name one more, which is diagnosed"),
    ],
)
def test_a_recording_that_cannot_be_held_out_is_named_before_any_work(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, folders: tuple[Path, ...], name: str, said: str
) -> None:
    ran = run(capfd, "run", *folders, "--out", tmp_path / "out", "--held-out", name)
    assert ran.status == 1
    assert said in ran.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("ratio", "said"), [(1.234, "1.2 × noise"), (101.4, "101 × noise")])
def test_the_table_says_at_how_many_times_noise_the_model_simulates(ratio: float, said: str) -> None:
    adequacy = ModelAdequacy(ratio, 1.7, "the angle of motor 4").as_json()
    assert adequacy["explains"] is (ratio < 3)
    assert dict(zip(COLUMNS, row_cells("day1", _row(adequacy)), strict=True))["model"] == said


def test_what_could_not_be_simulated_is_said_so() -> None:
    assert model_adequacy(None) is None
    assert dict(zip(COLUMNS, row_cells("day1", _row(None)), strict=True))["model"] == "not simulated"


def _row(adequacy: dict[str, object] | None) -> dict[str, object]:
    return {
        "failure": None,
        "done_before": False,
        "faults": [],
        "recovered": [],
        "frames": 300,
        "frames_used": 299,
        "offset_s": 0.5,
        "offset_sigma_s": 1e-5,
        "verdict": "consistent",
        "parameters": [],
        "seconds": 12.0,
        "adequacy": adequacy,
    }
