"""Laws that no catalogue lists, one by one: names, terms, units and forces written out by hand."""

import math

import numpy as np
import pytest

from discovery.form import FORMS, Form
from mechanism.arm import arm_of
from mechanism.description import read_neck
from mechanism.laws import CableMotion, JointMotion, Law, MotorMotion, Term
from mechanism.laws.unlisted import VARIABLES, UnlistedLaw, Variable, law_name
from tests.paths import NECK_FILE

ARM = arm_of(read_neck(NECK_FILE))


def form(name: str, amounts: int = 1) -> Form:
    return next(f for f in FORMS if f.name == name and (len(f.amounts) == amounts or name != "polynomial"))


ALONG = "sign(motor_speed)"


def variable(acts: str, name: str, factor: str = "") -> Variable:
    return next(v for v in VARIABLES if (v.acts, v.name, v.factor) == (acts, name, factor))


HARMONIC = variable("motor", "motor_angle")
ACROSS = next(v for v in VARIABLES if v.span == (2, 3))


@pytest.mark.parametrize(
    ("law", "name"),
    [
        ((HARMONIC, form("harmonic"), 1), "motor.harmonic.motor_angle"),
        ((HARMONIC, form("harmonic"), 2), "motor.harmonic.motor_angle.2"),
        ((variable("motor", "time", ALONG), form("exponential"), 3), "motor.exponential.time.along.3"),
        ((variable("joint", "joint_speed"), form("levelling off"), 1), "joint.levelling_off.joint_speed"),
        ((variable("joint", "joint_angle"), form("polynomial", 2), 1), "joint.polynomial.joint_angle.degree2"),
        ((variable("motor", "tension", ALONG), form("polynomial", 3), 4), "motor.polynomial.tension.along.degree3.4"),
        ((variable("motor", "drum_angle", "force"), form("harmonic"), 1), "motor.harmonic.drum_angle.by_force"),
        ((variable("joint", "time", "joint_speed"), form("hinge"), 2), "joint.hinge.time.by_joint_speed.2"),
        ((variable("joint", "joint_angle", "sign(joint_speed)"), form("bump"), 1), "joint.bump.joint_angle.along"),
        ((variable("encoder", "motor_angle"), form("harmonic"), 1), "encoder.harmonic.motor_angle"),
        ((ACROSS, form("hinge"), 1), "joint.hinge.joint_angle.over_2_to_3"),
        ((ACROSS, form("polynomial", 2), 2), "joint.polynomial.joint_angle.over_2_to_3.degree2.2"),
    ],
)
def test_a_name_says_all(law: tuple[Variable, Form, int], name: str) -> None:
    assert law_name(*law) == name
    assert UnlistedLaw(*law).name == name


def test_without_a_number_a_law_is_the_first_of_its_kind() -> None:
    assert law_name(HARMONIC, form("harmonic")) == "motor.harmonic.motor_angle"


def test_amounts_are_of_places_and_constants_of_the_arm() -> None:
    at, everything = {"of": "cable", "linear": True}, {"high": math.inf, "of": "arm", "linear": False}
    cogging, name = UnlistedLaw(HARMONIC, form("harmonic"), 1), "motor.harmonic.motor_angle"
    assert cogging.terms == (
        Term(f"{name}.cosine", "N", low=-math.inf, high=math.inf, size=1.0, **at),  # type: ignore[arg-type]
        Term(f"{name}.sine", "N", low=-math.inf, high=math.inf, size=1.0, **at),  # type: ignore[arg-type]
        Term(f"{name}.count", "1", low=1e-6, size=1.0, **everything),  # type: ignore[arg-type]
    )
    assert cogging.amount_terms == cogging.terms[:2]
    assert cogging.constant_terms == cogging.terms[2:]
    bump, name = UnlistedLaw(variable("joint", "joint_angle"), form("bump"), 1), "joint.bump.joint_angle"
    at = {"of": "joint", "linear": True}
    assert bump.terms == (
        Term(f"{name}.height", "N m", low=-math.inf, high=math.inf, size=0.01, **at),  # type: ignore[arg-type]
        Term(f"{name}.place", "rad", low=-math.inf, size=0.1, **everything),  # type: ignore[arg-type]
        Term(f"{name}.width", "rad", low=1e-6, size=1.0, **everything),  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(
    ("acts", "name", "form_name", "places"),
    [("cable", "time", "exponential", {"begin"}), ("joint", "joint_speed", "hinge", {"place", "side"}),
     ("joint", "joint_speed", "smooth", {"low", "high"}), ("motor", "force", "power", set())],
)  # fmt: skip
def test_places_lie_anywhere_and_sizes_are_above_nothing(
    acts: str, name: str, form_name: str, places: set[str]
) -> None:
    law = UnlistedLaw(variable(acts, name), form(form_name), 1)
    for constant, term in zip(law.form.constants, law.constant_terms, strict=True):
        assert (term.low, term.size) == ((-math.inf, 0.1) if constant in places else (1e-6, 1.0))


def test_units_follow_from_powers_of_the_variable() -> None:
    units = [term.unit for term in UnlistedLaw(variable("joint", "joint_speed"), form("polynomial", 3), 1).terms]
    assert units == ["N m/(rad/s)", "N m/(rad/s)^2", "N m/(rad/s)^3"]
    units = [term.unit for term in UnlistedLaw(variable("motor", "force"), form("polynomial", 2), 1).terms]
    assert units == ["1", "N/N^2"]
    units = [term.unit for term in UnlistedLaw(variable("motor", "force"), form("power"), 1).terms]
    assert units == ["N", "1", "N"]
    by = {"force": "1", "motor_speed": "N s/rad", "sign(motor_speed)": "N", "": "N"}
    assert {f: variable("motor", "time", f).unit_of_law for f in by} == by
    by = {"joint_speed": "N m s/rad", "sign(joint_speed)": "N m", "": "N m"}
    assert {f: variable("joint", "time", f).unit_of_law for f in by} == by


def test_what_a_law_follows_is_known_of_it() -> None:
    """A drum that winds unevenly has another lever at every angle: what its motor feels is in proportion to the tension."""
    told = {v: UnlistedLaw(v, FORMS[0], 1) for v in VARIABLES}
    reading = ("encoder", "motor_angle")
    rubbing = {("motor", "tension"), ("cable", "motor_angle"), ("cable", "drum_angle"), reading}
    assert {(v.acts, v.name) for v, law in told.items() if law.rubs_under_tension} == rubbing
    by_force = {("motor", name) for name in ("force", "motor_angle", "drum_angle", "time")}
    assert {(v.acts, v.name) for v, law in told.items() if law.follows_force} == by_force | {reading}
    assert all("force" in (v.name, v.factor) for v, law in told.items() if law.follows_force and not v.misreads)
    turning = (
        {("motor", v.name) for v in VARIABLES if v.acts == "motor"} | {reading} | (rubbing - {("motor", "tension")})
    )
    assert {(v.acts, v.name) for v, law in told.items() if law.changes_motor_force} == turning
    assert variable("motor", "tension", ALONG).follows == ("tension", "motor_speed")
    assert variable("motor", "time", "force").follows == ("time", "force")
    assert variable("joint", "time", "sign(joint_speed)").follows == ("time", "joint_speed")
    assert variable("motor", "tension").follows == ("tension",)
    assert [variable(acts, "time").unit_of_law for acts in ("motor", "cable", "joint")] == ["N", "N", "N m"]
    assert [variable("cable", name).unit_of_law for name in ("drum_angle", "motor_angle")] == ["m", "m"]
    sizes = [
        UnlistedLaw(variable("cable", name), form("harmonic"), 1).terms[0].size
        for name in ("drum_angle", "motor_angle")
    ]
    assert sizes == [1e-4, 1e-5]


MOTOR = MotorMotion(
    theta_d=np.full(4, 2.0), tension=np.full(4, 30.0), wrap=np.zeros(4), theta=np.full(4, 0.5),
    drum_angle=np.full(4, 0.02), force=np.full(4, 40.0), time=np.full(4, 3.0), arm=ARM,
)  # fmt: skip
CABLE = CableMotion(
    x=np.zeros(4), x_d=np.zeros(4), length=np.ones(4), arm=ARM, travel_d=np.full(4, 0.05), drum_angle=np.full(4, 0.02),
    theta=np.full(4, 0.5), time=np.full(4, 3.0),
)  # fmt: skip
DRY = 2 / math.pi * math.atan(0.25 * 2.0)
JOINT = JointMotion(alpha=np.full(3, 0.3), alpha_d=np.full(3, -0.7), time=np.full(3, 3.0))
SLIDES = -0.7 / 0.03  # of the speed within which a joint's direction turns over
FACTORS = {
    "": 1.0, "sign(motor_speed)": DRY, "motor_speed": 2.0, "force": 40.0, "joint_speed": -0.7,
    "sign(joint_speed)": SLIDES / (1 + abs(SLIDES) ** 2.7) ** (1 / 2.7),
}  # fmt: skip
SEEN = {
    ("motor", "force"): 40.0, ("motor", "tension"): 30.0, ("motor", "motor_angle"): 0.5, ("motor", "drum_angle"): 0.02,
    ("motor", "motor_speed"): 2.0, ("motor", "time"): 3.0, ("cable", "motor_angle"): 0.5, ("cable", "drum_angle"): 0.02,
    ("cable", "time"): 3.0, ("joint", "joint_angle"): 0.3, ("joint", "joint_speed"): -0.7, ("joint", "time"): 3.0,
}  # fmt: skip


@pytest.mark.parametrize(
    "v",
    [v for v in VARIABLES if v.joints <= 3 and not v.misreads],
    ids=lambda v: f"{v.acts}-{v.name}-{v.factor or v.place}",
)
def test_a_law_acts_where_it_says_on_what_it_says(v: Variable) -> None:
    """Three times the cosine and five times the sine of twice a turn, or seven times the variable; and what multiplies it."""
    x = SEEN[v.acts, v.name]
    spanned = np.arange(1, 4)
    spanned = (spanned >= v.span[0]) & (spanned <= v.span[1]) if v.span else np.ones(1)
    x *= spanned.sum()
    if v.kind == "turn":
        law, constants, amounts = UnlistedLaw(v, form("harmonic"), 1), {"count": 2.0}, [3.0, 5.0]
        expected = 3 * math.cos(2 * x) + 5 * math.sin(2 * x)
    else:
        law, constants, amounts = UnlistedLaw(v, form("polynomial"), 1), {}, [7.0]
        expected = 7 * x
    places = law.amount_terms[0].count(ARM)
    numbers = {"cm": 0.25, "k": 800.0, "ca": 60.0}
    values = law.values(np.repeat(np.array(amounts)[:, None], places, axis=1), constants)
    values |= {name: np.full(1, value) for name, value in numbers.items()}
    found = {
        "motor": law.friction(values, MOTOR),
        "cable": law.pull(values, CABLE, np.zeros((4, 0))),
        "joint": law.resistance(values, JOINT),
    }
    forces = {v.acts: expected * FACTORS[v.factor] * spanned}
    if v.acts == "cable" and v.kind == "turn":
        # so much longer is the cable, and by so much less than a radian's travel it is wound in a radian of the motor
        gear = 25.0 if v.name == "drum_angle" else 1.0
        share = (-6 * math.sin(2 * x) + 10 * math.cos(2 * x)) / (gear * 0.010 / 25.0)
        forces = {"cable": 800 * expected + 60 * share * 0.05, "motor": share * 30.0}
    for acts, force in found.items():
        if acts in forces:
            np.testing.assert_allclose(force, np.full(3 if acts == "joint" else 4, forces[acts]), rtol=1e-6)
        else:
            assert not np.any(force)


def test_a_law_of_the_listed_kind_does_nothing_where_it_does_not_say() -> None:
    """The methods that a law does not override."""
    law, z = Law(), np.ones((4, 2))
    assert float(law.friction({}, MOTOR)) == float(law.pull({}, CABLE, z)) == float(law.resistance({}, JOINT)) == 0.0
    np.testing.assert_array_equal(law.memory_rate({}, CABLE, z), np.zeros((4, 2)))
    assert law.acting_force({}, z, 0.002) is law.commanded_force({}, z, 0.002) is z


@pytest.mark.parametrize(("of", "count"), [("cable", 4), ("joint", 3), ("arm", 1)])
def test_a_term_has_as_many_numbers_as_there_are_places(of: str, count: int) -> None:
    assert Term("a", "N", low=0.0, high=1.0, size=1.0, of=of).count(ARM) == count  # type: ignore[arg-type]


def test_an_encoder_that_reads_too_much_by_hand() -> None:
    """Of the angle to which the motor has turned, found by turns; cable, friction and inertia as that angle has them."""
    law = UnlistedLaw(variable("encoder", "motor_angle"), form("harmonic"), 1)
    cosine, sine, turned = 0.003, 0.005, 0.5
    for _ in range(20):
        turned = 0.5 - cosine * math.cos(2 * turned) - sine * math.sin(2 * turned)
    slope = -2 * cosine * math.sin(2 * turned) + 2 * sine * math.cos(2 * turned)
    bend = -4 * (0.5 - turned)
    # a radian of the reading is less of the angle
    share, bent = slope / (1 + slope), bend / (1 + slope) ** 3
    values = law.values(np.repeat([[cosine], [sine]], 4, axis=1), {"count": 2.0})
    values |= {"cm": np.full(1, 0.25), "k": np.full(1, 800.0), "ca": np.full(1, 60.0)}
    values |= {"fs": np.full(1, 12.0), "fv": np.full(1, 0.3)}

    def rubs(speed: float) -> float:
        return 12.0 * 2 / math.pi * math.atan(0.25 * speed) + 0.3 * speed

    drum, inertia = 0.010 / 25.0, ARM.motor_inertia[0] / ARM.drum[0]
    pull = -800.0 * drum * (0.5 - turned) - 60.0 * share * 0.05
    speeding_up = (40.0 - 30.0 - rubs(2.0 * (1 - share)) + inertia * bent * 2.0**2) / (1 - share)
    found = law.pull(values, CABLE, np.zeros((4, 0))), law.friction(values, MOTOR)
    np.testing.assert_allclose(found[0], np.full(4, pull), rtol=1e-3)
    np.testing.assert_allclose(found[1], np.full(4, 40.0 - 30.0 - rubs(2.0) - speeding_up), rtol=1e-2)
