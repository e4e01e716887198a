"""Figures show what was computed."""

import numpy as np

from identification.fasquelle.reconstruction import reconstruct
from synchronisation.check.explained_elongation import explain
from xneck.recording.recording_result import RecordingResult


def test_couples_and_tensions_are_those_that_were_fitted(result: RecordingResult) -> None:
    """What the figures show leaves the residuals of the fits behind the tables, and the tensions of the identification."""
    found, identified = reconstruct(result.data, result.fasquelle), result.fasquelle
    for couple, fit in (
        (found.couple_dry, identified.dry_only),
        (found.couple_dry_and_viscous, identified.dry_and_viscous),
    ):
        np.testing.assert_allclose((found.couple_measured - couple).ravel(), fit.estimate.residuals, atol=1e-9)
    np.testing.assert_allclose(found.tension_from_force, identified.tension_from_force)
    for model, error in identified.tension_error.items():
        np.testing.assert_allclose(found.tension_error(model), error, atol=1e-9)


def test_elongations_are_explained_as_the_check_does(result: RecordingResult) -> None:
    found = explain(result.data.arm, result.data.state)
    rms = np.sqrt(np.mean((found.x - found.explained) ** 2, axis=0))
    np.testing.assert_allclose(rms, [cable["unexplained_rms"] for cable in result.data.check["cables"]], rtol=1e-6)
