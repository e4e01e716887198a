"""Stretches that are set aside, where they meet."""

import pytest

from diagnosis.residual_episodes import Episode
from diagnosis.short_disturbances import _joined


@pytest.mark.parametrize(
    ("stretches", "joined"),
    [
        ([Episode(0, 5.0, 6.0), Episode(0, 6.0, 7.0)], (Episode(0, 5.0, 7.0),)),
        ([Episode(0, 5.0, 6.0), Episode(0, 6.5, 7.0)], (Episode(0, 5.0, 6.0), Episode(0, 6.5, 7.0))),
        ([Episode(0, 5.0, 6.0), Episode(1, 4.0, 7.0)], (Episode(0, 5.0, 6.0), Episode(1, 4.0, 7.0))),
        ([], ()),
    ],
)
def test_stretches_are_one_where_they_touch_in_one_recording(
    stretches: list[Episode], joined: tuple[Episode, ...]
) -> None:
    assert _joined(stretches) == joined
