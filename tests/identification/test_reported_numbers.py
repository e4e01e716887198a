"""Estimates as they are reported: of parameters made up, each of another size, so that none can stand for another."""

import numpy as np

from identification.estimates import Estimates
from identification.fitting import FitSolution
from identification.identifiability import Identifiability
from identification.unknowns import unknowns
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))
X0 = np.array([1e-3, 2e-3, 4e-3, 8e-3])
LAWS = ("dry_friction", "linear_cable")


def made_up(recordings: int) -> Estimates:
    u = unknowns(ARM, LAWS, recordings)
    count = len(u.entries)
    sigma = 0.1 * np.arange(1, count + 1, dtype=np.float64)
    return Estimates(
        laws=LAWS,
        unknowns=u,
        solution=FitSolution(
            p=np.arange(count, dtype=np.float64) + 0.5,
            covariance=np.diag(sigma**2),
            least_squares=np.zeros(count),
            least_squares_covariance=np.eye(count),
            difference_covariance=np.eye(count),
            blocks=30,
            information=np.eye(count),
            residuals=(
                np.array([[3.0, -3.0], [4.0, 4.0], [1.0, 7.0], [0.0, 0.0], [2.0, 2.0], [0.1, 0.1], [5.0, 5.0]]),
            ),
            at_bound=np.zeros(count, dtype=bool),
            instrumented=np.zeros(count, dtype=bool),
        ),
        identifiability=tuple(
            Identifiability(i % 2 == 0, "identified" if i % 2 == 0 else "flat") for i in range(count)
        ),
        x0=X0,
        seconds=(12.0,) * recordings,
        checks=({"verdict": None, "usable": None, "faults": []},) * recordings,
    )


def test_each_cables_pre_elongation_is_the_descriptions_and_what_was_found_beyond() -> None:
    """fs 4, cm 1, k 4, ca 4, then x0 4 and the delay: x0 stands at places 13 to 16 of the vector."""
    x0 = [p for p in made_up(1).parameters if p.name == "x0"]
    assert [p.index for p in x0] == [1, 2, 3, 4]
    np.testing.assert_allclose([p.value for p in x0], [13.501, 14.502, 15.504, 16.508], rtol=1e-12)
    np.testing.assert_allclose([p.sigma for p in x0], [1.4, 1.5, 1.6, 1.7], rtol=1e-12)
    assert [p.identified for p in x0] == [False, True, False, True]


def test_the_laws_numbers_are_as_they_were_fitted_and_nothing_of_several_recordings_is_one_parameter() -> None:
    for recordings in (1, 2):
        found = made_up(recordings)
        of_laws = [(p.name, p.index, p.value) for p in found.parameters if p.name != "x0"]
        expected = [("fs", j, j - 0.5) for j in (1, 2, 3, 4)] + [("cm", None, 4.5)]
        expected += [("k", j, j + 4.5) for j in (1, 2, 3, 4)] + [("ca", j, j + 8.5) for j in (1, 2, 3, 4)]
        assert of_laws == expected
        assert any(p.name == "x0" for p in found.parameters) == (recordings == 1)
        np.testing.assert_allclose(np.diag(found.covariance), [p.sigma**2 for p in found.parameters])


def test_residuals_are_the_root_of_their_mean_square_by_equation() -> None:
    motor, arm = made_up(1).rms()
    np.testing.assert_allclose(motor, [3.0, 4.0, 5.0, 0.0])
    np.testing.assert_allclose(arm, [2.0, 0.1, 5.0])
