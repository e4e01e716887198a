"""What is known of a marker's depth before any recording."""

import pytest

from mechanism.printed_markers import BarMarker


@pytest.mark.parametrize(
    ("depth", "sigma", "known"),
    [
        (None, None, (0.0, 0.010)),  # nobody measured it: a centimetre, as workshops are
        (0.03, None, (0.03, 0.001)),  # by a rule: a millimetre
        (0.03, 0.004, (0.03, 0.004)),
        (None, 0.002, (0.0, 0.002)),  # in the plane, as far as that is known
    ],
)
def test_a_depth_is_as_well_known_as_is_written(
    depth: float | None, sigma: float | None, known: tuple[float, float]
) -> None:
    assert BarMarker(id=3, bar=1, depth=depth, depth_sigma=sigma).depth_known == known
