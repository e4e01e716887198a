"""Which function of which variable explains a force that no law knows of: put into the log by hand."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.advice import BY_VARIABLE, look_for_law
from diagnosis.cause_fit import CauseFitter
from diagnosis.free_function import FREE_FUNCTIONS, VARIABLES, FreeFit, best_free_function
from diagnosis.hypothesis import as_described
from diagnosis.noise_columns import noise_columns
from diagnosis.noise_ensemble import noise_ensemble
from diagnosis.unlisted_laws import AGAINST_JOINTS, AGAINST_SEVERAL_JOINTS, OF_ENCODERS, found_laws
from discovery.fine_basis import FineBasis
from discovery.problem import Candidate
from identification.dataset.dataset import DataSet
from identification.dataset.frames import frame_angles
from identification.dataset.series import Series, numbered_columns
from tests.identification.test_estimates import recording

Array = np.ndarray


def test_there_is_advice_for_every_variable() -> None:
    assert set(BY_VARIABLE) == {variable.name for variable in VARIABLES}


@pytest.mark.parametrize(
    ("detail", "follows", "word"),
    [
        (OF_ENCODERS, "motor_angle", "encoder"),
        ("against the motors", "motor_angle", "poles"),
        (AGAINST_SEVERAL_JOINTS, "joint_angle", "loom"),
        (AGAINST_JOINTS, "joint_angle", "stop"),
    ],
)
def test_advice_names_what_may_act_there(detail: str, follows: str, word: str) -> None:
    basis = FineBasis(np.zeros(1))
    assert word in look_for_law(Candidate("all", (follows,), "rad", "turn", basis, detail=detail))


def explained(data: DataSet) -> FreeFit:
    fitter = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)])
    found = best_free_function(fitter.base_model(), fitter.whiten)
    assert found
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "follows"),
    [
        (lambda s: 3 * np.sin(5 * s.matrix("theta")), "motor's turn"),
        (lambda s: 4 * np.exp(-s.time[:, None] / 5) * np.sign(s.matrix("theta", "_d")), "time, along the motion"),
        (lambda s: 2e-3 * (s.matrix("f") - s.matrix("f").mean(axis=0)) ** 2, "force"),
    ],
)
def test_a_hidden_force_is_told_by_its_variable(force: Callable[[Series], Array], follows: str) -> None:
    """The motors were told more than reached the arm."""
    data = recording(8000)
    told = data.state.matrix("f") + force(data.state)
    state = Series(data.state.time, {**data.state.columns, **numbered_columns("f", told)})
    found = explained(replace(data, state=state))
    assert (found.function.equation, found.function.follows) == ("motors", follows)
    assert found.explains > 0.8


def test_functions_begin_as_constants() -> None:
    """Pieces along a variable add up to one everywhere: a constant is a function too."""
    data = recording(2000)
    fitter = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)])
    (at,) = fitter.base_model().comparison.linearisation.recordings
    pieces = [function for function in FREE_FUNCTIONS if not function.variable.turn_harmonics]
    for function in pieces:
        np.testing.assert_allclose(function.patterns(at).sum(axis=0), 1.0)


def test_a_force_that_never_changes_is_no_variable_of_its_motor() -> None:
    """Forms are tried where a place went: there is none between 40 N and 40 N."""
    data = recording(2000)
    state = {**data.state.columns, "f3": np.full(len(data.state), 40.0)}
    data = replace(data, state=Series(data.state.time, state))
    fitter = CauseFitter(as_described(data.neck), [noise_ensemble(data, frame_angles(data), 0)])
    stage = fitter.base_model()
    laws = next(found_laws(stage, fitter.whiten, noise_columns(stage, fitter.ensembles)), ())
    assert not any(law.candidate.where == "motor 3" and "force" in law.candidate.follows for law in laws)
