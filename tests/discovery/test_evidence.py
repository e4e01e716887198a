"""Products by blocks against the same by rows."""

import numpy as np
import pytest

from discovery.evidence import FOLDS, TOLD_SHARE, Evidence
from discovery.fine_basis import FineBasis
from discovery.form import FORMS, Form

RNG = np.random.default_rng(3)
ROWS, BLOCKS = 600, 20
BASE, ASKED, TARGET = RNG.normal(size=(ROWS, 3)), RNG.normal(size=(ROWS, 6)), RNG.normal(size=ROWS)
BLOCK = np.arange(ROWS) * BLOCKS // ROWS
FUNCTION = RNG.normal(size=(6, 2))
EVIDENCE = Evidence.of(BASE, np.zeros(3), ASKED, TARGET, BLOCK)


def test_numbers_loss_and_gain_are_those_of_least_squares() -> None:
    columns = np.column_stack([BASE, ASKED @ FUNCTION])
    x, loss, *_ = np.linalg.lstsq(columns, TARGET)
    _, without, *_ = np.linalg.lstsq(BASE, TARGET)
    assert EVIDENCE.fit(FUNCTION) == pytest.approx(x, rel=1e-6)
    assert EVIDENCE.loss(FUNCTION) == pytest.approx(loss[0], rel=1e-9)
    assert EVIDENCE.gains(FUNCTION[None])[0] == pytest.approx(without[0] - loss[0], rel=1e-4)


def test_losses_of_blocks_are_those_of_fits_to_the_others() -> None:
    columns, fold = np.column_stack([BASE, ASKED @ FUNCTION]), BLOCK % FOLDS
    expected = np.zeros(BLOCKS)
    own = ASKED @ FUNCTION - BASE @ np.linalg.lstsq(BASE, ASKED @ FUNCTION)[0]
    held = np.zeros((5, 5))
    held[3:, 3:] = TOLD_SHARE * own.T @ own
    for f in range(FOLDS):
        told, target = columns[fold != f], TARGET[fold != f]
        x = np.linalg.solve(told.T @ told + held, told.T @ target)
        expected += np.bincount(BLOCK, ((TARGET - columns @ x) ** 2) * (fold == f), BLOCKS)
    assert EVIDENCE.block_losses(FUNCTION) == pytest.approx(expected, rel=1e-6)


def test_what_acts_in_one_block_is_not_predicted_by_what_the_others_get_wrong() -> None:
    """A hinge that force passes in one block, and only just in another, where something else is wrong by as much as noise."""
    acts = np.zeros((ROWS, 1))
    acts[BLOCK == 7] = 1.0
    acts[BLOCK == 9] = 1e-3
    target = 5 * acts[:, 0] + RNG.normal(size=ROWS) + (BLOCK == 9)
    evidence = Evidence.of(BASE, np.zeros(3), acts, target, BLOCK)
    gains = evidence.block_losses(np.zeros((1, 0))) - evidence.block_losses(np.eye(1))
    (amount,) = evidence.fit(np.eye(1))[3:]
    assert amount == pytest.approx(5, abs=4 / np.sqrt(ROWS / BLOCKS))
    # the others' rows would have an amount of a thousand, and a loss of millions
    assert abs(gains[7]) < 0.2 * 25 * ROWS / BLOCKS
    assert np.abs(np.delete(gains, 7)).max() < 10


def test_sigma_of_white_noise_is_that_of_least_squares() -> None:
    columns = np.column_stack([BASE, ASKED @ FUNCTION])
    plain = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    # blocks tell a variance to a share of sqrt(2 / blocks), and rows for themselves are the least
    assert np.sqrt(np.diag(EVIDENCE.covariance(FUNCTION))) == pytest.approx(plain, rel=1.0)
    assert np.all(np.sqrt(np.diag(EVIDENCE.covariance(FUNCTION))) > 0.99 * plain)


@pytest.mark.parametrize("size", [1e-161, 1e-170, 0.0])
def test_a_column_too_small_to_be_squared_tells_nothing(size: float) -> None:
    """As a bump has at a place to which a motor never turns: its product with others is a number yet, and its square is not."""
    asked = np.column_stack([ASKED[:, 0], size * (ASKED[:, 0] + 1e-3 * ASKED[:, 1])])
    evidence = Evidence.of(BASE, np.zeros(3), asked, TARGET, BLOCK)
    alone = Evidence.of(BASE, np.zeros(3), asked[:, :1], TARGET, BLOCK)
    x = evidence.fit(np.eye(2))
    assert x[:4] == pytest.approx(alone.fit(np.eye(1)), rel=1e-6)
    assert abs(x[4]) * size < 1e-9
    assert evidence.loss(np.eye(2)) == pytest.approx(alone.loss(np.eye(1)), rel=1e-9)
    assert evidence.gains(np.eye(2)[None])[0] == pytest.approx(alone.gains(np.eye(1)[None])[0], rel=1e-4)


def test_what_is_known_beforehand_holds_numbers() -> None:
    known = Evidence.of(BASE, np.full(3, 1e12), ASKED, TARGET, BLOCK)
    assert known.fit(FUNCTION)[:3] == pytest.approx(0.0, abs=1e-8)


def test_chance_takes_as_much_as_two_numbers_do() -> None:
    gradients = EVIDENCE.block_gradients(FUNCTION)
    signs = np.random.default_rng(4).choice([-1.0, 1.0], (2000, BLOCKS))
    gains = EVIDENCE.chance_gains(FUNCTION[None], gradients, signs)
    # chi square of two: mean 2; blocks of one draw of noise tell it to about a third
    assert 1.2 < gains.mean() < 3.0


@pytest.mark.parametrize("form", FORMS, ids=lambda f: f"{f.name} of {f.kinds[0]}, {len(f.amounts)}")
def test_fine_columns_add_up_to_every_form(form: Form) -> None:
    is_turn = "turn" in form.kinds
    values = np.random.default_rng(5).uniform(-3, 3, 4000) * (4 if is_turn else 1)
    basis = FineBasis.of([values], is_turn)
    for constants in form.starts(basis)[:: max(1, len(form.starts(basis)) // 4)]:
        if constants.get("width", 1) < (0.3 if is_turn else 0.5):
            continue  # narrower ones are only roughly told by fine columns, and refined by rows
        wanted = form.columns(values, constants)
        made = basis.columns(values) @ basis.coefficients(lambda x, c=constants: form.columns(x, c))
        error = (made - made.mean(axis=0)) - (wanted - wanted.mean(axis=0))
        assert np.sqrt(np.mean(error**2)) < 0.02 * np.abs(wanted).max()
