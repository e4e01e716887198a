"""Arms of the independent generator whose drawing is off, calibrated on frames with noise; and their motors alone.

Each is made once in a session: integration forward takes seconds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet, state_series
from identification.dataset.series import Series, numbered_columns
from identification.model_file import Model, ModelParameter
from identification.pose_calibration import calibrated_model
from mechanism.arm import arm_of
from mechanism.description import Neck
from mechanism.laws import LAWS
from samples.forward_arms import Settings, make_arms
from samples.forward_arms.arms import Arm, Recording
from samples.forward_arms.drawing import neck as neck_of
from samples.forward_arms.laws import Law, Payload, ViscousFriction
from xneck_foundation.strict_yaml import validate_document

Array = NDArray[np.float64]

NOISE_RAD = np.radians(0.02)
SETTLED = 500
"""rows after which the observer is judged"""


@dataclass(frozen=True)
class Case:
    """The arm's description, its model calibrated on a first recording, and the log and truth of a second."""

    neck: Neck
    model: Model
    log: Series
    alpha: Array
    """(rows, N), rad"""
    alpha_d: Array


SEEDS = (5010, 5011)
CHANGES: dict[str, Law] = {"load": Payload(0.3), "friction": ViscousFriction(np.full(4, 0.15))}
"""what the second of the arms did not have when it was calibrated"""


@cache
def _made() -> dict[int, Arm]:
    arms = make_arms(SEEDS, Settings(seconds=14.0, drawing_off=1.0, noise_deg=0.02, step=2e-3))
    return {arm.seed: arm for arm in arms}


@cache
def _changed() -> dict[str, Arm]:
    settings = Settings(seconds=11.0, drawing_off=1.0, step=2e-3, recordings=1, first_recording=1)
    seeds = [SEEDS[1]] * len(CHANGES)
    return dict(zip(CHANGES, make_arms(seeds, settings, hidden=[(law,) for law in CHANGES.values()]), strict=True))


@cache
def case(seed: int, calibrated: bool = True) -> Case:
    """An arm in lively motion."""
    arm = _made()[seed]
    described = validate_document(neck_of(arm.drawing), Neck, "neck.yaml")
    model = base_model(described, arm.drawing.stiffness)
    if calibrated:
        model = calibrated_model(model, [dataset(described, arm.recordings[0], seed)]).model
    return Case(described, model, *second_recording(arm.recordings[1]))


def built_stiffness(seed: int) -> Array:
    """Of the cables as they are, (M,), N/m."""
    return _made()[seed].plant.stiffness


@cache
def calibration_data(seed: int) -> tuple[DataSet, DataSet]:
    """Both recordings with a camera."""
    neck = case(seed, calibrated=False).neck
    first, second = _made()[seed].recordings
    return dataset(neck, first, seed), dataset(neck, second, seed + 1)


def changed(name: str) -> Case:
    """The second arm with one of CHANGES, and the model that it had before."""
    before = case(SEEDS[1])
    return Case(before.neck, before.model, *second_recording(_changed()[name].recordings[0]))


@cache
def unexplained(name: str) -> Case:
    """The changed arm with a model that was calibrated on it as it is, without a law for the change."""
    before = case(SEEDS[1], calibrated=False)
    recording = _changed()[name].recordings[0]
    posed = calibrated_model(before.model, [dataset(before.neck, recording, SEEDS[1])])
    return Case(before.neck, posed.model, *second_recording(recording))


def with_laws(of: Case, laws: Sequence[str], numbers: Mapping[str, float]) -> Case:
    """The same arm with a model that has more laws, whose numbers, by their names, are the same for each cable or joint."""
    arm = arm_of(of.neck)
    parameters = tuple(
        ModelParameter(
            name=term.name,
            index=None if term.of == "arm" else i + 1,
            value=numbers[term.name],
            unit=term.unit,
            sigma=None,
            relative_sigma_percent=None,
            identified=True,
        )
        for name in laws
        for term in LAWS[name].terms
        for i in range(term.count(arm))
    )
    more = {"laws": (*of.model.laws, *laws), "parameters": (*of.model.parameters, *parameters)}
    return replace(of, model=of.model.model_copy(update=more))


def second_recording(recording: Recording) -> tuple[Series, Array, Array]:
    """Its log, with true angles and speeds of the joints in the log's rows, (rows, N), rad and rad/s."""
    truth = recording.truth.within_log()
    rows = slice(None, None, truth.per_row)
    log = Series(recording.time, numbered_columns("theta", recording.theta) | numbered_columns("f", recording.f))
    return log, truth.alpha[rows], truth.alpha_d[rows]


def base_model(neck: Neck, stiffness: Array) -> Model:
    """As `identify` might have found it: friction and stiffness wrong by tens of per cents, damping not at all."""
    rng = np.random.default_rng(0)
    parameters = []
    for j in range(neck.M):
        for name, value, sigma, sure in (
            ("fs", 14.0 * rng.uniform(0.85, 1.15), 2.0, True),
            ("fv", 0.0, 0.02, False),
            ("k", stiffness[j] * rng.uniform(0.8, 1.2), 0.07 * stiffness[j], True),
            ("ca", 50.0, 500.0, False),
        ):
            parameters.append(
                ModelParameter(
                    name=name,
                    index=j + 1,
                    value=value,
                    unit="",
                    sigma=sigma,
                    relative_sigma_percent=None,
                    identified=sure,
                )
            )
    parameters.append(
        ModelParameter(
            name="cm", index=None, value=0.5, unit="s/rad", sigma=0.1, relative_sigma_percent=None, identified=True
        )
    )
    return Model(laws=("dry_friction", "viscous_friction", "linear_cable"), parameters=tuple(parameters))


def dataset(neck: Neck, recording: Recording, seed: int) -> DataSet:
    """A recording as `sync` would make it, its clock off by a millisecond: frames with noise, the state without."""
    truth, rng = recording.truth.within_log(), np.random.default_rng([seed, 9])
    rows = slice(None, None, truth.per_row)
    arm, time = arm_of(neck), truth.time[rows]
    off = 1e-3

    def at(values: Array) -> Array:
        return np.stack([np.interp(time + off, truth.time, column) for column in values.T], axis=-1)

    step = float(np.mean(np.diff(truth.time)))
    theta_dd = np.gradient(truth.theta_d, step, axis=0)
    state = state_series(
        arm,
        time,
        (at(truth.alpha), at(truth.alpha_d), at(truth.alpha_dd)),
        (truth.theta[rows], truth.theta_d[rows], theta_dd[rows]),
        recording.f,
    )
    frames = np.arange(time[0] + 0.1, time[-1] - 0.1, 1 / 30)
    seen = np.stack([np.interp(frames + off, truth.time, column) for column in truth.alpha.T], axis=-1)
    seen = seen + NOISE_RAD * rng.standard_normal(seen.shape)
    angles = Series(frames, numbered_columns("alpha", seen) | numbered_columns("sigma", np.full_like(seen, NOISE_RAD)))
    nothing = Series(np.empty(0), {})
    return DataSet(
        neck=neck,
        neck_yaml="",
        state=state,
        fasquelle=nothing,
        angles=angles,
        log=nothing,
        clock={"offset_s": 0.0, "offset_sigma_s": 1e-3},
    )
