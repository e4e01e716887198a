"""A cause of the catalogue and a law that no catalogue holds at once: each is named as what it is, with its numbers."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from diagnosis import causes_beside_laws
from diagnosis.cause import Cause
from diagnosis.causes_beside_laws import Explanation
from diagnosis.diagnose import diagnose
from diagnosis.effects import EFFECTS
from diagnosis.noise_excess import NoiseExcess
from discovery.form import SMOOTH
from mechanism.arm import arm_of
from mechanism.description import read_neck
from tests.hidden_arms import PAYLOAD, STOP, seen_arms
from tests.paths import NECK_FILE
from xneck.report.diagnosis_text import diagnosis_sentence

STIFFNESS, SLACK, MASS = STOP.stiffness, STOP.slack, PAYLOAD.mass


def test_a_payload_beside_a_stop_is_named_and_weighed() -> None:
    """A loom of leads holds the first joint beyond 0.2 rad: while that is unknown no choice of causes explains the arm."""
    first, second = (seen_arms()["payload beside a stop"].synchronised(i) for i in range(2))
    found = diagnose([first], [second])
    assert [cause.effect.name for cause in found.causes] == ["tip_payload"]
    (gained,) = found.found_laws
    assert gained.law.words == "against joint 1: hinge of joint_angle"
    numbers = {p.name: p for p in gained.law.parameters}
    assert abs(numbers["slope"].value - STIFFNESS) < 4 * numbers["slope"].sigma < 0.1 * STIFFNESS
    assert abs(numbers["place"].value - SLACK) < 4 * numbers["place"].sigma < 0.05
    assert np.abs(found.causes[0].amounts[0] - MASS) < 0.15 * MASS
    assert found.verdict == "cause"
    assert found.why == "found beside the catalogue: against joint 1: hinge of joint_angle"
    assert all(r.ratio < 1.25 for r in found.remainder)
    assert "tip_payload" not in found.detectability.invisible
    sentence = diagnosis_sentence(found)
    assert "he arm carries something at its tip" in sentence
    assert "; and a law that no catalogue lists acts against joint 1: hinge of joint angle." in sentence


@pytest.mark.parametrize(
    ("dry", "variable", "causes", "may_be"),
    [
        (-0.005, "joint_speed", 1, True),  # friction that pushes, and a law of the speed that holds: air drag
        (0.02, "joint_speed", 1, False),  # friction that holds, of a form that a law mends
        (-0.005, "joint_angle", 1, False),  # a law of something else
        (-0.005, "joint_speed", 2, False),
    ],
)
def test_one_cause_at_its_least_and_a_law_of_its_variable_may_be_one_law(
    dry: float, variable: str, causes: int, may_be: bool
) -> None:
    """Of drag by the square of speed viscous joint friction and tanh were left, which cancel where it is slow."""
    described = arm_of(read_neck(NECK_FILE))
    effect = EFFECTS["joint_friction"]
    everywhere = effect.placements(described)[0]
    amounts = np.repeat([dry, 0.5], described.N)
    cause = Cause(effect, everywhere, amounts, dict(effect.start_shapes[0]))
    law = SimpleNamespace(law=SimpleNamespace(candidate=SimpleNamespace(variable=variable)))
    stage = SimpleNamespace(causes=[cause], before_causes=SimpleNamespace(arm=described))
    search = SimpleNamespace(named=[cause] * causes)
    assert Explanation(cast("Any", search), cast("Any", (law,)), cast("Any", stage)).may_be_one_law == may_be


def explanation(ratio: float, *names: str, laws: int = 1) -> Any:
    """What leaves so many times noise, with causes of these names before its laws."""
    causes = tuple(SimpleNamespace(name=name) for name in (*names, *["law"] * laws))
    fitter = SimpleNamespace(whiten=None)
    search = SimpleNamespace(named=names, last=SimpleNamespace(causes=names), fitter=fitter)
    stage = SimpleNamespace(excess=NoiseExcess(np.array([ratio]), np.ones(1)), causes=causes)
    return SimpleNamespace(search=search, laws=[None] * laws, stage=stage)


@pytest.mark.parametrize(
    ("ratios", "promised", "law_ratio", "asked", "kept"),
    [
        ((5.0, 1.9, 1.05), 0.0, None, ["causes"] * 3, 1.05),  # each finds more beside the law as it was fitted
        # the second finds hardly anything, and there is no other law: the first stays
        ((5.0, 4.9), 0.0, None, ["causes", "causes", "law"], 5.0),
        ((1.05,), 0.0, None, ["causes"], 1.05),  # nothing is left
        (
            (5.0,),
            0.9,
            1.05,
            ["causes", "law"],
            1.05,
        ),  # straight lines promise no cause, and another law explains the rest
        ((5.0, 4.9), 0.0, 1.05, ["causes", "causes", "law"], 1.05),  # they promise one in vain
        ((5.0,), 0.9, 4.9, ["causes", "law"], 5.0),  # nor does another law explain much of it
    ],
)
def test_causes_then_another_law_are_sought_beside_a_law_as_it_was_fitted_with_the_first(
    ratios: tuple[float, ...],
    promised: float,
    law_ratio: float | None,
    asked: list[str],
    kept: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """promised: share that causes would leave by straight lines; law_ratio: what another law leaves, if there is one."""
    found = iter(explanation(ratio, *["cause"] * (i + 1)) for i, ratio in enumerate(ratios))
    order: list[str] = []

    def once(search: Any, laws_found: Any, laws: Any, causes: Any, *_: object) -> Any:
        assert [law.name for law in laws] == ["law"]
        assert len(causes) == order.count("causes")
        order.append("causes")
        return next(found)

    def another_law(*_: object) -> Any:
        order.append("law")
        return None if law_ratio is None else explanation(law_ratio, "cause")

    monkeypatch.setattr(causes_beside_laws, "_causes_found_beside", once)
    monkeypatch.setattr(causes_beside_laws, "_with_another_law", another_law)
    monkeypatch.setattr(causes_beside_laws, "share_that_causes_leave", lambda *_: promised)
    best = causes_beside_laws._causes_beside(explanation(9.0).search, explanation(9.0), [0], (), 0, ())
    assert best is not None
    assert best.stage.excess.ratio[0] == kept
    assert order == asked


@pytest.mark.parametrize(
    ("form", "variable", "at_once"),
    [
        ("bump", "motor_angle", True),
        (SMOOTH, "motor_angle", True),
        (SMOOTH, "motor_speed", False),  # may stand in for friction
    ],
)
def test_further_laws_are_looked_for_only_where_causes_beside_the_first_leave_something(
    form: str, variable: str, at_once: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    law = SimpleNamespace(form=SimpleNamespace(name=form), words=f"{form} of {variable}")
    law.candidate = SimpleNamespace(variable=variable, is_sibling=lambda other: other is law.candidate)
    asked: list[int] = []

    def growing(*_: object) -> Any:
        for count in (1, 2):
            asked.append(count)
            yield (law,) * count

    def gained(search: Any, laws: Any, *_: object) -> Any:
        return SimpleNamespace(laws=[SimpleNamespace(law=each) for each in laws], stage=explanation(5.0).stage)

    monkeypatch.setattr(causes_beside_laws, "found_laws", growing)
    monkeypatch.setattr(causes_beside_laws, "law_gains", gained)
    monkeypatch.setattr(causes_beside_laws, "noise_columns", lambda *_: ())
    monkeypatch.setattr(causes_beside_laws, "_causes_beside", lambda *_: explanation(1.05, "tip_payload"))
    last = SimpleNamespace(causes=())
    search = SimpleNamespace(fitter=SimpleNamespace(whiten=None, ensembles=()), last=last, named=())
    best = causes_beside_laws._beside_causes(cast("Any", search), None, (), 0, ())
    assert best.stage.excess.ratio[0] == 1.05
    assert asked == ([1] if at_once else [1, 2])
