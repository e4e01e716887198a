"""Flicker is told by its rms from frame to frame."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from xneck.watch.light_findings import light_findings


def lit(level: np.ndarray) -> list[Any]:
    """Frames, 30 in a second, of two markers whose white follows a level about one."""
    return [
        SimpleNamespace(
            time=k / 30,
            white=np.array([200.0, 150.0]) * share,
            black=np.array([30.0, 20.0]),
            bright=np.array([190.0, 140.0]) * share,
            picture=(20.0, 180.0),
        )
        for k, share in enumerate(level.tolist())
    ]


@pytest.mark.parametrize("seed", range(4))
def test_light_that_flickers_by_two_percent_is_let_pass_and_by_six_is_named(seed: int) -> None:
    """White noise of unit rms in the 61 frames that are judged: its rms is then known to 16 %."""
    noise = np.random.default_rng(seed).normal(size=61)
    assert light_findings(lit(1 + 0.02 * noise / noise.std())) == []
    (finding,) = light_findings(lit(1 + 0.06 * noise / noise.std()))
    assert (finding.kind, finding.onset_s) == ("flicker", 0.0)
    told = float(finding.what.removeprefix("the light flickers by ").split(" %")[0])
    assert told == pytest.approx(6.0, rel=0.3)
