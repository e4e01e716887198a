"""`xneck design` draws by its seed."""

from pathlib import Path

import pytest

from tests.command import run
from tests.paths import NECK_FILE


def test_another_seed_gives_another_motion_and_the_same_one_the_same(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def motion(name: str, seed: int) -> bytes:
        words = ("--seconds", "5", "--tries", "3", "--for", "k", "--seed", str(seed))
        done = run(capfd, "design", NECK_FILE, "--out", tmp_path / name, *words)
        assert done.status == 0, done.err
        return (tmp_path / name).read_bytes()

    first = motion("a.csv", 1)
    assert motion("b.csv", 1) == first
    assert motion("c.csv", 2) != first
