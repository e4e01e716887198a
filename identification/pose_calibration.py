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

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.model_file import Model, PoseModel, PoseNumber, PoseResidual, arm_digest
from identification.pose_equations import Misfit, PoseEquations
from identification.pose_numbers import sought_numbers
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
_SHARED_LAGS = 8
"""frames by which those are apart at most whose products tell what is left (docs/thresholds.md)"""
_SLOPE_S = 0.1
"""over which a residual's change is taken"""
_GROWTH_SIGMAS = 2.0
"""of chance, by which changes of residuals must grow with time (docs/thresholds.md)"""
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


def with_pose(model: Model, recordings: Sequence[DataSet], neck: Neck | None = None) -> Model:
    """The model with the numbers by which motors tell the joints; as it is where these recordings do not tell them."""
    try:
        return model.model_copy(update={"pose": calibrate_pose(recordings, model, neck)})
    except Refused:
        return model


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
                misfit.angles, self.equations.rows[r].frames.sigma ** 2, self.equations.held_variance(p, r, compliance)
            )
            for r, (misfit, compliance) in enumerate(zip(misfits, compliances, strict=True))
        ]
        slopes = [
            residual_slope(misfit.angles, rows.frames.alpha, rows.frames.time)
            for rows, misfit in zip(self.equations.rows, misfits, strict=True)
        ]
        motor = np.sqrt(np.mean(np.concatenate([m.motors for m in misfits]) ** 2, axis=0))
        return PoseModel(
            arm=arm_digest(self.equations.neck),
            numbers=tuple(
                PoseNumber(
                    name=n.name,
                    index=n.index,
                    kind="drawing" if n.drawing else ("x0" if n.name == "x0" else "law"),
                    value=float(value[i]),
                    sigma=float(np.sqrt(whole[i, i])),
                )
                for i, n in enumerate(self.equations.numbers)
                if i in set(kept)
            ),
            covariance=tuple(tuple(float(v) for v in row) for row in whole[np.ix_(kept, kept)]),
            residual=PoseResidual(
                angle_rad=tuple(float(v) for v in np.sqrt(np.mean(np.square(left), axis=0))),
                motor_N=tuple(float(v) for v in motor),
                low_alpha=tuple(float(v) for v in np.min([r.alpha.min(axis=0) for r in self.equations.rows], axis=0)),
                high_alpha=tuple(float(v) for v in np.max([r.alpha.max(axis=0) for r in self.equations.rows], axis=0)),
                slope=tuple(float(v) for v in np.sqrt(np.mean(np.square(slopes), axis=0))),
                seconds=max(float(r.frames.time[-1] - r.frames.time[0]) for r in self.equations.rows),
            ),
        )


def rms_beyond_noise(angles: Array, noise: Array, held: Array) -> Array:
    """What is left of angles (F, N), rad, NaN where not seen, beyond their noise, (N,), rad.

    Frames up to _SHARED_LAGS apart tell it, whose noise differs, and in which what lasts is the same. noise, held: variances
    (F, N), rad^2, of a frame and by what friction holds: the larger this one is, the less a frame says.
    """
    out = []
    for own, square, weight in zip(angles.T, noise.T, (noise / (noise + held)).T, strict=True):
        total = weights = 0.0
        for lag in range(1, min(_SHARED_LAGS, len(own) - 1) + 1):
            both = np.isfinite(own[lag:]) & np.isfinite(own[:-lag])
            each = np.sqrt(weight[lag:] * weight[:-lag])[both]
            total += float(np.sum((own[lag:] * own[:-lag])[both] * each))
            weights += float(np.sum(each))
        shared = total / weights if weights else float(np.mean(square))
        out.append(np.sqrt(max(shared, 0.0)))
    return np.array(out)


def residual_slope(residual: Array, alpha: Array, time: Array) -> Array:
    """How much residuals (F, N), rad, NaN where not seen, change along a radian of motion, rms, (N,).

    alpha: angles of the frames, (F, N), rad; time: (F,), s. Changes over a tenth of a second and over the next one tell it, whose
    noise differs; where residuals jump and stay, as with play, these have nothing in common, and their growth with time does.
    """
    span = max(1, round(_SLOPE_S / max(float(np.median(np.diff(time))), 1e-9))) if len(time) > 1 else 1
    changes, moved = residual[span:] - residual[:-span], alpha[span:] - alpha[:-span]
    gap = span + 1
    products, path = changes[gap:] * changes[:-gap], np.sum(moved[gap:] * moved[:-gap], axis=1)
    seen = np.isfinite(products).all(axis=1) & np.isfinite(path)
    power = float(np.sum(np.abs(path[seen])))
    if power == 0:
        return np.zeros(residual.shape[1])
    lasting = np.sum(products[seen], axis=0) / power
    return np.sqrt(np.maximum(np.maximum(lasting, _growth(residual, alpha, span)), 0.0))


def _growth(residual: Array, alpha: Array, span: int) -> Array:
    """By how much squares of changes over `span` frames exceed those from frame to frame, along squares of the motion, (N,).

    White noise is the same in both; what it leaves by chance is taken off."""
    squares, paths = [], []
    for frames in (1, span):
        change, moved = residual[frames:] - residual[:-frames], alpha[frames:] - alpha[:-frames]
        seen = np.isfinite(change).all(axis=1) & np.isfinite(moved).all(axis=1)
        squares.append(np.sum(change[seen] ** 2, axis=0) / max(seen.sum(), 1))
        paths.append(float(np.sum(moved[seen] ** 2)) / max(seen.sum(), 1))
    chance = _GROWTH_SIGMAS * squares[0] * np.sqrt(3 / len(residual))
    return (squares[1] - squares[0] - chance) / max(paths[1] - paths[0], 1e-300) if span > 1 else np.zeros_like(chance)


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
