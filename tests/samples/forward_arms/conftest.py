"""Arms that are integrated once for all tests."""

import pytest

from samples.forward_arms.arms import Arm, make_arms
from tests.samples.forward_arms.plants import SHORT


@pytest.fixture(scope="session")
def arms() -> list[Arm]:
    """Two arms with a short recording each."""
    return list(make_arms([11, 12], SHORT))
