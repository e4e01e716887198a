"""`xneck run`: which recording is held out."""

from pathlib import Path

import pytest

from tests.command import run
from tests.paths import SAMPLES

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
