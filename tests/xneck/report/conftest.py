"""The result that the tests of a recording's page share."""

import pytest

from tests.xneck.report.sample_result import sample_result
from xneck.recording.recording_result import RecordingResult


@pytest.fixture(scope="session")
def result(tmp_path_factory: pytest.TempPathFactory) -> RecordingResult:
    return sample_result(tmp_path_factory.mktemp("recording"))
