"""A model whose numbers are changed by hand."""

from identification.model_file import Model, ModelParameter, PoseModel, PoseNumber, PoseResidual


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


def test_a_pose_goes_with_the_numbers_it_was_found_with() -> None:
    """Motors told the joints with the stiffness as it was; where nothing is changed they still do."""
    stiffer = MODEL.with_(k=[8000.0, 9000.0])
    assert [p.value for p in stiffer.parameters] == [8000.0, 9000.0]
    assert stiffer.pose is None
    assert MODEL.with_().pose == POSE
