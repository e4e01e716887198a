"""Numbers of arm and laws by which motor angles tell the joints: what a camera leaves behind for when it is gone.

`identify` asks what friction and elasticity are if the drawing is right. Where joints shall be told without a camera the question
is another one: with which numbers, of laws and drawing together, does the arm stand where the camera saw it? With the motors'
angles given, cables pull the arm to where

    Z t(alpha, theta) = M alpha'' + c + g + joint friction                                    (44), (53)

so that numbers are sought which put every frame's angles there. Numbers of the drawing are known to their tolerance beforehand,
those of the laws as `identify` left them; the motors' equation (43) tells the level of the tensions. Rows of correlated residuals
count for what they are worth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.model_file import Model, PoseModel, PoseNumber, PoseResidual, arm_digest
from identification.pose_equations import Misfit, PoseEquations
from identification.pose_numbers import sought_numbers
from identification.pose_residual import frame_step, lasting_rms, residual_rate, rms_beyond_noise
from identification.pose_rows import rows_of
from identification.pose_start import LEAST_MOTOR_N, begun_by_motors, check_motors, motor_rms
from mechanism.description import Neck
from xneck_foundation.errors import Refused
from xneck_foundation.one_blas_thread import one_blas_thread

Array = NDArray[np.float64]

_MAX_ITERATIONS, _TOLERANCE = 12, 0.01
"""of Gauss and Newton; prior sigmas of every number that the last step changes at most"""
_MAX_STEP = 10.0
"""prior sigmas by which a number moves at once"""
_WEIGHTED_ANEW = 6
"""iterations in which weights follow the residuals"""
_STEP = 1e-3
"""prior sigmas: of the differences"""
_LAGS = 60
"""frames up to which residuals are taken to be correlated"""
_MOTOR_HZ = 1.0
"""independent values of the motors' equation in a second (docs/thresholds.md)"""


@one_blas_thread
def calibrate_pose(recordings: Sequence[DataSet], model: Model, neck: Neck | None = None) -> PoseModel:
    """Numbers of arm and laws by which motors tell the joints, fitted to recordings of one arm.

    neck: the description that the numbers are relative to; that of the recordings unless given. Raises Refused where no frame shows
    all joints.

    >>> import xneck
    >>> pose = xneck.calibrate_pose([xneck.read_dataset("monday.mcap")], xneck.read_model("model.yaml"))
    >>> max(pose.residual.angle_rad) < 0.01  # rad, what it leaves of each joint beyond the frames' noise
    True
    """
    neck = neck or recordings[0].neck
    rows = [rows_of(data) for data in recordings]
    if not sum(np.isfinite(r.frames.alpha).all(axis=1).sum() for r in rows):
        raise Refused("identify", "no frame shows all joints", "record with every marker in view")
    try:
        with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
            told = PoseEquations(neck, model, rows, sought_numbers(neck, model, rows))
            equations = PoseEquations(neck, model, rows, begun_by_motors(told))
            fit = _Fit(equations)
            start = np.zeros(len(equations.numbers))
            for r in range(len(rows)):
                equations.move(start, r)
            begun = motor_rms(equations, start)
            p, covariance = fit.solved()
            check_motors(begun, motor_rms(equations, p))
            return fit.result(p, covariance)
    except np.linalg.LinAlgError as error:
        raise Refused(
            "identify", f"motors cannot be made to tell the joints ({error})", "is a column in another unit?"
        ) from error


@dataclass(frozen=True)
class PoseOutcome:
    """A model with the numbers by which motors tell the joints, or as it was where recordings do not tell them, and why not."""

    model: Model
    refused: str | None

    def as_json(self) -> dict[str, Any]:
        """For the record of the stage that wrote the model."""
        pose = None if self.refused else self.model.pose
        return {"calibrated": pose is not None, "left_rad": pose and list(pose.residual.angle_rad), "why": self.refused}

    def as_text(self) -> str:
        """For a person: empty where it was calibrated."""
        return f"\nthe model has no pose, and `observe` will be less sure of it: {self.refused}" if self.refused else ""


def calibrated_model(model: Model, recordings: Sequence[DataSet], neck: Neck | None = None) -> PoseOutcome:
    """The model with the numbers by which motors tell the joints, as calibrate_pose finds them."""
    try:
        return PoseOutcome(model.model_copy(update={"pose": calibrate_pose(recordings, model, neck)}), None)
    except Refused as refused:
        return PoseOutcome(model, str(refused))


class _Fit:
    """Gauss and Newton on the equations."""

    def __init__(self, equations: PoseEquations) -> None:
        self.equations = equations
        self._sigmas: dict[int, tuple[Array, Array]] = {}

    def solved(self) -> tuple[Array, Array]:
        """Numbers in prior sigmas, with their covariance."""
        p: Array = np.zeros(len(self.equations.numbers))
        covariance: Array = np.asarray(np.eye(len(p)), dtype=np.float64)
        for iteration in range(_MAX_ITERATIONS):
            for r in range(len(self.equations.rows)):
                self.equations.move(p, r)
                if iteration < _WEIGHTED_ANEW:
                    self._sigmas[r] = self._sigma(p, r)
            normal, gradient = np.eye(len(p)), -p
            for r in range(len(self.equations.rows)):
                own_normal, own_gradient = self._normal_equations(p, r)
                normal, gradient = normal + own_normal, gradient + own_gradient
            if not (np.isfinite(normal).all() and np.isfinite(gradient).all()):
                raise Refused(
                    "identify", "no numbers put the arm where the camera saw it", "is it this arm's neck.yaml?"
                )
            step = np.linalg.solve(normal, gradient)
            step *= min(1.0, _MAX_STEP / max(float(np.max(np.abs(step))), 1e-300))
            best = np.clip(p + step, self.equations.low, self.equations.high)
            change = float(np.max(np.abs(best - p)))
            p, covariance = best, np.asarray(np.linalg.inv(normal), dtype=np.float64)
            if change < _TOLERANCE:
                break
        return p, covariance

    def _sigma(self, p: Array, r: int) -> tuple[Array, Array]:
        """Sigma of the frames' angles, (F, N), rad, and of the motors' equation in each row, (M,), N."""
        compliance = self.equations.compliance(p, r)
        misfit, held = self.equations.misfit(p, r, compliance), self.equations.held_variance(p, r, compliance)
        return self._angle_sigma(misfit, held, r), self._motor_sigma(misfit, r)

    def _normal_equations(self, p: Array, r: int) -> tuple[Array, Array]:
        compliance = self.equations.compliance(p, r)
        base = self.equations.misfit(p, r, compliance)
        seen = np.isfinite(base.angles)
        weight, motor_weight = (1 / sigma for sigma in self._sigmas[r])
        angle_columns, motor_columns = [], []
        for i, n in enumerate(self.equations.numbers):
            if n.recording not in (None, r):
                angle_columns.append(np.zeros(int(seen.sum())))
                motor_columns.append(np.zeros(base.motors.size))
                continue
            q = p.copy()
            q[i] += _STEP
            other = self.equations.misfit(q, r, compliance)
            angle_columns.append((((base.angles - other.angles) / _STEP) * weight)[seen])
            motor_columns.append((((base.motors - other.motors) / _STEP) * motor_weight).ravel())
        H, G = np.stack(angle_columns, axis=1), np.stack(motor_columns, axis=1)
        normal = H.T @ H + G.T @ G
        gradient = H.T @ (base.angles * weight)[seen] + G.T @ (base.motors * motor_weight).ravel()
        return normal, gradient

    def _angle_sigma(self, misfit: Misfit, held: Array, r: int) -> Array:
        """Sigma of each frame's angles, (F, N), rad, wider by how much residuals exceed what is expected and are correlated.

        Expected are the frames' noise and `held`, the variance of what friction holds."""
        sigma = np.sqrt(self.equations.rows[r].frames.sigma ** 2 + held)
        ratio = np.nanvar(misfit.angles / sigma, axis=0)
        widened = np.sqrt(np.maximum(ratio, 1.0) * np.array([_correlation_time(a) for a in (misfit.angles / sigma).T]))
        return sigma * widened

    def _motor_sigma(self, misfit: Misfit, r: int) -> Array:
        """Sigma of the motors' equation in each row, (M,), N."""
        rows_each = max(1.0, 1 / (_MOTOR_HZ * self.equations.rows[r].step))
        return np.maximum(np.sqrt(np.mean(misfit.motors**2, axis=0)), LEAST_MOTOR_N) * np.sqrt(rows_each)

    def result(self, p: Array, covariance: Array) -> PoseModel:
        """The fit as the model's file has it: numbers of arm and laws; x0 where there is one recording."""
        alone = len(self.equations.rows) == 1
        entries = enumerate(self.equations.numbers)
        kept = [i for i, n in entries if n.recording is None or (alone and n.name == "x0")]
        value = self.equations.mean + p * self.equations.sigma
        whole = covariance * np.outer(self.equations.sigma, self.equations.sigma)
        compliances = [self.equations.compliance(p, r) for r in range(len(self.equations.rows))]
        misfits = [self.equations.misfit(p, r, compliance) for r, compliance in enumerate(compliances)]
        left = [
            rms_beyond_noise(
                misfit.angles,
                rows.frames.sigma**2,
                self.equations.held_variance(p, r, compliance),
                frame_step(rows.frames.time),
            )
            for r, (rows, misfit, compliance) in enumerate(zip(self.equations.rows, misfits, compliances, strict=True))
        ]
        lasting = [
            np.minimum(lasting_rms(misfit.angles, rows.frames.time), of_this)
            for rows, misfit, of_this in zip(self.equations.rows, misfits, left, strict=True)
        ]
        changes = [
            residual_rate(misfit.angles, rows.frames.alpha, rows.frames.time)
            for rows, misfit in zip(self.equations.rows, misfits, strict=True)
        ]
        rates, slopes = zip(*changes, strict=True)
        motor = np.sqrt(np.mean(np.concatenate([m.motors for m in misfits]) ** 2, axis=0))
        return PoseModel(
            arm=arm_digest(self.equations.neck),
            numbers=tuple(
                PoseNumber(
                    name=n.name,
                    index=n.index,
                    kind=n.kind,
                    value=float(value[i]),
                    sigma=float(np.sqrt(whole[i, i])),
                )
                for i, n in enumerate(self.equations.numbers)
                if i in set(kept)
            ),
            covariance=tuple(tuple(float(v) for v in row) for row in whole[np.ix_(kept, kept)]),
            residual=PoseResidual(
                angle_rad=tuple(float(v) for v in np.sqrt(np.mean(np.square(left), axis=0))),
                rate_rad_s=tuple(float(v) for v in np.sqrt(np.mean(np.square(rates), axis=0))),
                lasting_rad=tuple(float(v) for v in np.sqrt(np.mean(np.square(lasting), axis=0))),
                motor_N=tuple(float(v) for v in motor),
                low_alpha=tuple(float(v) for v in np.min([r.alpha.min(axis=0) for r in self.equations.rows], axis=0)),
                high_alpha=tuple(float(v) for v in np.max([r.alpha.max(axis=0) for r in self.equations.rows], axis=0)),
                slope=tuple(float(v) for v in np.sqrt(np.mean(np.square(slopes), axis=0))),
                seconds=max(float(r.frames.time[-1] - r.frames.time[0]) for r in self.equations.rows),
                count_rad=tuple(float(v) for v in np.max([r.count_angles for r in self.equations.rows], axis=0)),
            ),
        )


def _correlation_time(residual: Array) -> float:
    """Rows of a residual (F,) that count as one, NaN where unknown: the sum of its correlations up to the first below zero."""
    r = np.where(np.isfinite(residual), residual - np.nanmean(residual), 0.0)
    power = float(r @ r)
    if power == 0:
        return 1.0
    total = 1.0
    for lag in range(1, min(_LAGS, len(r) - 1)):
        correlation = float(r[lag:] @ r[:-lag]) / power
        if correlation <= 0:
            break
        total += 2 * correlation
    return total
