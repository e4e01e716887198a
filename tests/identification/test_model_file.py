"""A model whose numbers a person sets."""

import numpy as np

from identification.model_file import (
    Model,
    ModelParameter,
    PoseModel,
    PoseNumber,
    PoseResidual,
    covariance_as_described_of,
    covariance_of,
    model_of,
)
from xneck_foundation.parameter import Parameter


def parameter(name: str, index: int, value: float) -> ModelParameter:
    return ModelParameter(
        name=name, index=index, value=value, unit="N/m", sigma=9.0, relative_sigma_percent=0.1, identified=True
    )


POSE = PoseModel(
    numbers=(PoseNumber(name="k", index=1, kind="law", value=8000.0, sigma=9.0),),
    covariance=((81.0,),),
    residual=PoseResidual(angle_rad=(1e-3,), motor_N=(0.1,), low_alpha=(-0.5,), high_alpha=(0.5,)),
)
MODEL = Model(
    laws=("linear_cable",),
    parameters=(parameter("k", 1, 8000.0), parameter("k", 2, 7000.0)),
    covariance=((81.0, 5.0), (5.0, 81.0)),
    pose=POSE,
)
COVARIANCE = np.array([[4.0, 1.0, 2.0], [1.0, 9.0, 3.0], [2.0, 3.0, 16.0]])
"""of fs, k and ca"""


def friction_and_elasticity(as_described: np.ndarray | None = None) -> Model:
    """Fasquelle's width of friction was never fitted, and has no covariance."""
    parameters = [
        Parameter(name=name, index=None, value=value, unit=unit, sigma=sigma, identified=True)
        for name, value, unit, sigma in (("fs", 15.0, "N", 2.0), ("k", 9e3, "N/m", 3.0), ("ca", 60.0, "N s/m", 4.0))
    ]
    return model_of(parameters, ("dry_friction", "linear_cable"), {}, COVARIANCE, covariance_as_described=as_described)


def test_a_pose_goes_with_the_numbers_it_was_found_with() -> None:
    """Motors told the joints with the stiffness as it was; where nothing is changed they still do."""
    stiffer = MODEL.with_(k=[8000.0, 9000.0])
    assert [p.value for p in stiffer.parameters] == [8000.0, 9000.0]
    assert stiffer.pose is None
    assert MODEL.with_().pose == POSE


def test_what_is_set_covaries_with_nothing_and_the_rest_as_before() -> None:
    model = friction_and_elasticity(COVARIANCE / 4).with_(k=8e3)
    assert [(p.name, p.value, p.sigma) for p in model.parameters[:3]] == [
        ("fs", 15.0, 2.0),
        ("k", 8e3, None),
        ("ca", 60.0, 4.0),
    ]
    expected = np.array([[4.0, 0.0, 2.0], [0.0, 0.0, 0.0], [2.0, 0.0, 16.0]])
    np.testing.assert_array_equal(covariance_of(model)[:3, :3], expected)
    np.testing.assert_array_equal(covariance_as_described_of(model)[:3, :3], expected / 4)


def test_of_a_model_beside_an_exact_drawing_both_covariances_are_one() -> None:
    np.testing.assert_array_equal(covariance_as_described_of(friction_and_elasticity())[:3, :3], COVARIANCE)
