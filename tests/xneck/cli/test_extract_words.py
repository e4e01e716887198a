"""What `xneck extract` says of markers on a terminal."""

from pathlib import Path

import pytest

from xneck.cli.extract import _summary


@pytest.mark.parametrize(
    ("duplicates", "says"),
    [
        (0, "id 2 0.0 %, id 3"),
        (1, "id 2 0.0 % (twice in view in 1 frame, left out there), id 3"),
        (102, "in 102 frames"),
    ],
)
def test_a_marker_that_is_twice_in_view_is_named(duplicates: int, says: str) -> None:
    """Else its share reads as if it had been hidden."""
    seen = [{"id": 2, "seen_share": 0.0, "duplicates": duplicates}, {"id": 3, "seen_share": 1.0, "duplicates": 0}]
    nothing = {"gaps": [], "warnings": [], "drift": [], "askew": None, "placement": None}
    result = {"frames": 270, "frames_with_all_angles": 270, "sigma_alpha_median_rad": None, "corner_sigma_px": 0.03}
    assert says in _summary(Path("angles.mcap"), {**result, "markers": seen, **nothing})
