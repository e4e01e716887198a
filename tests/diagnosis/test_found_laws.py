"""A law that no catalogue holds, hidden in an arm that the second generator integrates: found, fitted, written and simulated."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis import causes_beside_laws, law_gains
from diagnosis.diagnose import Diagnosis, diagnose
from diagnosis.extended_model import extended_description, extended_model
from diagnosis.record import as_json, as_text
from diagnosis.unlisted_laws import AGAINST_JOINTS, AGAINST_SEVERAL_JOINTS, OF_ENCODERS, _StageProblem, causes_of
from discovery.found_law import FoundLaw
from identification.dataset.dataset import DataSet
from identification.estimates import LAWS_BY_ELASTIC_MODEL, estimate
from identification.model_file import machine_of, model_of, read_model, unlisted_laws_of, write_model
from identification.simulation.simulated_recording import simulate_recording
from mechanism.arm import arm_of
from tests.hidden_arms import COGGING, seen_arms
from xneck.report.diagnosis_page import DiagnosisResult, write_diagnosis_report
from xneck_foundation.errors import Refused

POLES, FORCE = round(COGGING.poles), COGGING.force


@pytest.fixture(scope="module")
def recordings() -> list[DataSet]:
    return [seen_arms()["cogging"].synchronised(i) for i in range(2)]


@pytest.fixture(scope="module")
def found(recordings: list[DataSet]) -> Diagnosis:
    return diagnose(recordings[:1], recordings[1:])


def test_it_is_named_with_place_variable_form_and_numbers(found: Diagnosis) -> None:
    (gained,) = found.found_laws
    law = gained.law
    assert (law.candidate.where, law.candidate.follows, law.form.name) == ("all", ("motor_angle",), "harmonic")
    assert law.constants == {"count": POLES}
    for p in law.parameters:
        if p.name != "count":
            assert abs(p.value - {"sine": FORCE, "cosine": 0.0}[p.name]) < 4 * p.sigma
            assert p.sigma < 0.02 * FORCE
    assert found.causes == ()
    assert found.verdict == "unknown"


def test_what_it_leaves_where_it_was_not_fitted_is_noise(found: Diagnosis) -> None:
    (gained,) = found.found_laws
    assert gained.gain is not None
    assert gained.gain.before > 2 * gained.gain.noise_floor
    assert all(r.held_out and 0.8 < r.ratio < 1.25 for r in found.remainder)
    simulated = [g for g in found.gains if g.measure.startswith("simulated")]
    assert len(simulated) == 2
    assert all(g.after < 0.7 * g.before for g in simulated)


def test_a_law_that_does_not_hold_hides_none_after_it(
    recordings: list[DataSet], found: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    (gained,) = found.found_laws
    judged, refused = law_gains._holds, iter([True])
    monkeypatch.setattr(causes_beside_laws, "found_laws", lambda *_: iter([(gained.law, gained.law)]))
    monkeypatch.setattr(law_gains, "_holds", lambda *of_law: not next(refused, False) and judged(*of_law))
    again = diagnose(recordings[:1], recordings[1:])
    assert [each.law.words for each in again.found_laws] == [gained.law.words]


def test_record_text_and_page_say_so(found: Diagnosis, tmp_path: Path) -> None:
    (record,) = as_json(found)["found_laws"]
    assert record["where"] == "all"
    assert record["follows"] == ["motor_angle"]
    assert {"form", "words", "terms", "gain"} <= record.keys()
    assert {t["name"] for t in record["terms"]} == {"sine", "cosine", "count"}
    assert "harmonic of motor_angle" in as_text(found)
    write_diagnosis_report(DiagnosisResult("cogging", found, {"inputs": {}}), tmp_path / "diagnosis.html")
    page = (tmp_path / "diagnosis.html").read_text()
    assert "Laws that no catalogue lists" in page
    assert "harmonic of motor angle" in page


def test_it_is_written_with_the_model_and_simulated(
    found: Diagnosis, recordings: list[DataSet], tmp_path: Path
) -> None:
    neck = extended_description(found.extended_stage, recordings)
    write_model(extended_model(found.extended_stage, {}), tmp_path / "model.yaml")
    model = read_model(tmp_path / "model.yaml")
    assert "motor.harmonic.motor_angle" in model.laws
    machine = machine_of(model, arm_of(neck))
    np.testing.assert_allclose(machine.values["motor.harmonic.motor_angle.sine"], FORCE, rtol=0.02)
    other = found.extended_stage.adjusted(found.extended).corrected(recordings[1])
    with_law = simulate_recording(replace(other, neck=neck), model, max_parts=1, noise_floor=False)
    rest = tuple(p for p in model.parameters if not p.name.startswith("motor.harmonic"))
    base = model.model_copy(update={"laws": ("dry_friction", "linear_cable"), "parameters": rest})
    without = simulate_recording(replace(other, neck=neck), base, max_parts=1, noise_floor=False)
    assert _theta_rms(with_law) < 0.5 * _theta_rms(without)


def _theta_rms(simulated) -> float:
    return float(np.sqrt(np.mean([c.rms**2 for c in simulated.channels if c.name.startswith("theta")])))


def test_it_is_identified_again_on_another_recording(
    found: Diagnosis, recordings: list[DataSet], tmp_path: Path
) -> None:
    """Its amounts, with the inner constants of the model; the arm as drawn is off by its tolerances, which costs per cents."""
    write_model(extended_model(found.extended_stage, {}), tmp_path / "model.yaml")
    laws, held = unlisted_laws_of(read_model(tmp_path / "model.yaml"))
    assert held == {"motor.harmonic.motor_angle.count": POLES}
    estimates = estimate(recordings[1:], (*LAWS_BY_ELASTIC_MODEL[1], *laws), held)
    np.testing.assert_allclose(estimates.values("motor.harmonic.motor_angle.sine"), FORCE, rtol=0.06)
    model = model_of(estimates.parameters, estimates.laws, {}, estimates.covariance, held)
    again = machine_of(model, recordings[1].arm)
    assert again.values["motor.harmonic.motor_angle.count"].tolist() == [POLES]


@pytest.mark.parametrize(
    ("where", "follows", "detail", "differs"),
    [
        ("joints 1 to 2", "joint_angle", AGAINST_SEVERAL_JOINTS, 1e-6),
        ("joints 1 to 3", "joint_angle", AGAINST_SEVERAL_JOINTS, 1e-6),
        ("joint 2", "joint_angle", AGAINST_JOINTS, 1e-6),
        ("motor 3", "tension", "against the motors", 1e-6),
        # the law asks for the force that speeds the motor up, the search has the acceleration that was seen
        ("motor 2", "motor_angle", OF_ENCODERS, 0.05),
    ],
)
def test_a_law_is_looked_for_as_it_is_fitted(
    found: Diagnosis, where: str, follows: str, detail: str, differs: float
) -> None:
    """What a unit of it does to the whitened residuals is the same by the search's sums and by the machine's law."""
    search = found.search
    problem = _StageProblem(search.last, search.fitter.whiten, ())
    (candidate,) = (
        c for c in problem.candidates if (c.where, c.follows, c.factor, c.detail) == (where, (follows,), "", detail)
    )
    form = next(f for f in candidate.forms if f.name in ("polynomial", "harmonic"))
    count = len(form.amounts)
    law = FoundLaw(candidate, form, dict.fromkeys(form.constants, 1.0), 1e-4 * np.ones(count), np.eye(count))
    (cause,) = causes_of([law], found.extended.arm)
    (recording,) = problem._recordings
    by_law = problem._white(recording, problem._rows[0], cause.columns(recording) / cause.sizes(found.extended.arm))
    by_search = problem.columns(candidate, law.function)
    assert np.abs(by_law).max() > 1.0
    assert np.sqrt(np.mean((by_search - by_law) ** 2)) < differs * np.sqrt(np.mean(by_law**2))


def test_a_law_over_joints_that_an_arm_has_not_is_refused(found: Diagnosis) -> None:
    model = extended_model(found.extended_stage, {})
    model = model.model_copy(update={"laws": (*model.laws, "joint.hinge.joint_angle.over_2_to_5")})
    with pytest.raises(Refused, match="over_2_to_5 is of 5 joints at least; the arm has 3"):
        machine_of(model, found.extended.arm)
