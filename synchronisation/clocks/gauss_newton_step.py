"""One Gauss-Newton step on the cables' equation and the arm's together, as one weighted least squares."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from identification.unknowns import DELAY_SIGMA_S
from synchronisation.clocks.arm_equation import ArmRows
from synchronisation.clocks.cable_equation import FORCE_SCALE_N, CableRows, CableTerms
from synchronisation.clocks.frame_geometry import FrameGeometry, geometry_sigma, of_pulleys
from synchronisation.clocks.unknowns import ClockUnknowns
from synchronisation.error_sizes import covariance_of, likelier_sizes

Array = NDArray[np.float64]

BLOCK_S = 1.0
"""s: residuals may be correlated within blocks of this length and are independent from block to block"""
MAX_BLOCKS = 256
"""blocks of long recordings are longer, so that memory does not grow with their number"""
FV_SIGMA = 0.1
"""N s/rad: standard deviation of a motor's viscosity that is not given; no gear motor has more (docs/thresholds.md)"""
GIVEN_FV_SIGMA = 0.05
"""relative standard deviation of a viscosity that is given (docs/thresholds.md)"""
SKEW_SIGMA = 3e-4
"""ratio: standard deviation of the skew before any fit; quartz clocks keep to some 100 ppm (docs/thresholds.md)"""
SKEW_SCALE = 1e-4
"""ratio: unit of the skew in a step's vector"""
CHUNK_FRAMES = 1 << 11
"""frames whose products are formed at a time, so that memory does not grow with the recording"""
_FIXED = 1e-9
"""standard deviation of an unknown that a step must not move"""
_FIRST_TORQUE_ERROR = 0.01
"""N m: error of the arm's equation before friction is estimated, when the residual is mostly friction"""
_LEAST_FORCE_ERROR_N = 1e-3
"""N: no motor's force is believed to be better than this"""
_ERROR_STEPS = 8
"""steps of the errors of the arm's equation: they go on from step to step"""
_LEAST_ROWS_OF_A_CLASS = 40
"""rows of the arm's equation, three seconds of them, by which an error is estimated"""
_DATA_RIDGE = 1e-12
"""of columns scaled to one: keeps unknowns that nothing excites in their place"""


@dataclass(frozen=True)
class ModelAssumptions:
    """One set of assumptions about what is not known."""

    law: CableTerms = field(default_factory=CableTerms)
    """of the cables"""
    joint_width: float = 0.05
    """rad/s: speed over which a joint's dry friction turns over"""
    drawing_scale: float = 1.0
    """by how much larger than usual errors of masses and springs in neck.yaml may be"""
    skew_scale: float = 1.0
    """by how much further than usual clocks may run apart"""
    pulley_sigma: float = 0.0
    """relative standard deviation of pulleys' radii where the cables alone are fitted"""
    motors_stick: bool = False
    """friction may hold motors at rest by any force up to its greatest: what it is there no law of theirs says"""


@dataclass(frozen=True)
class StepRows:
    """The rows of both equations at one estimate."""

    frames: FrameGeometry
    cables: CableRows
    whitening: Array
    """(F, M, M): weights of the cables' rows"""
    arm: ArmRows | None
    """None: the cables alone, which cannot tell viscosity and delay from the offset"""


@dataclass(frozen=True)
class NormalEquations:
    """The solved equations of a step, with columns (P,) scaled by `size`."""

    scores: Array
    """(B, P): J^T residual of each of B blocks"""
    products: Array
    """(B, P, P): J^T J of each block"""
    information: Array
    """(P, P): J^T J + prior"""
    prior_weight: Array
    """(P,)"""
    size: Array
    """(P,)"""

    def covariance(self, count: int) -> Array:
        """Covariance (count, count) of the first `count` unknowns, whose residuals may be correlated within blocks.

        By the jackknife: how the unknowns change where one block is left out of the fit. Residuals of a fit are smaller than the
        errors, the more so the fewer frames there are for each unknown; what a block leaves in a fit without it is not."""
        shares = zip(self.scores, self.products, strict=True)
        changes = np.stack([np.linalg.solve(self.information - of_block, score)[:count] for score, of_block in shares])
        by_prior = np.linalg.inv(self.information)[:count] * np.sqrt(self.prior_weight)
        return (changes.T @ changes + by_prior @ by_prior.T) / np.outer(self.size[:count], self.size[:count])


@dataclass(frozen=True)
class Step:
    """A Gauss-Newton step, which may be taken in part."""

    equations: NormalEquations
    """that it solved"""
    _columns: "_Columns"
    _unknowns: ClockUnknowns
    _change: Array
    _centre: Array
    _sigma: Array
    _rows: StepRows
    _torque_whitening: Array | None
    _law: CableTerms

    def taken(self, share: float) -> ClockUnknowns:
        """The unknowns after a share of the step, but for cable_error and noise_scale."""
        return self._columns.moved(self._unknowns, self._columns.vector(self._unknowns) + share * self._change)

    def cost(self, unknowns: ClockUnknowns, residual: Array) -> float:
        """What the step lessens, of unknowns with residuals (F, M), m, of the cables' equation: squares over their variances."""
        white = np.einsum("fij,fj->fi", self._rows.whitening, residual)
        of_prior = (self._columns.vector(unknowns) - self._centre) / self._sigma
        cost = float(np.sum(white**2) + np.sum(of_prior**2))
        if self._rows.arm is None or self._torque_whitening is None:
            return cost
        torque = self._rows.arm.residual_at(unknowns, _forms(unknowns, self._rows.arm, self._law))
        return cost + float(np.sum(np.einsum("kij,kj->ki", self._torque_whitening, torque) ** 2))


def gauss_newton_step(
    rows: StepRows, unknowns: ClockUnknowns, assumptions: ModelAssumptions, fv: Array, skew_fixed: bool
) -> Step:
    """The step from an estimate. fv: (M,), N s/rad, NaN where not given."""
    arm, residual, whitening = rows.arm, None, None
    if arm is not None:
        unknowns, residual, whitening = _with_torque_errors(unknowns, arm, assumptions.law)
    columns = _Columns.of(unknowns, arm)
    sums = _NormalSums(columns.count, rows.frames.time)
    _add_cables(sums, columns, rows)
    if arm is not None and residual is not None and whitening is not None:
        white = np.einsum("kij,kj->ki", whitening, residual)
        sums.add(whitening @ columns.of_arm(arm, assumptions.law), white, arm.time - unknowns.offset)
    centre, sigma = _prior(columns, unknowns, assumptions, fv, arm, skew_fixed)
    vector = columns.vector(unknowns)
    products = sums.products.sum(axis=0)
    size = np.sqrt(np.diag(products))
    size = np.where(size > 0, size, 1.0)
    weight = 1 / (sigma * size) ** 2
    scaled = np.outer(size, size)
    information = products / scaled + np.diag(weight + _DATA_RIDGE)
    scores = sums.scores / size
    gradient = scores.sum(axis=0) + weight * size * (vector - centre)
    step = -np.asarray(np.linalg.solve(information, gradient), dtype=float) / size
    equations = NormalEquations(scores, sums.products / scaled, information, weight, size)
    return Step(equations, columns, unknowns, step, centre, sigma, rows, whitening, assumptions.law)


class _NormalSums:
    """Sums of products of weighted rows, which need not be there all at once."""

    def __init__(self, columns: int, time: Array) -> None:
        """time: (F,), s, of the frames; their span is cut into blocks."""
        self._first = time[0]
        duration = float(time[-1] - time[0])
        blocks = min(int(duration // BLOCK_S) + 1, MAX_BLOCKS)
        self._length = duration / blocks
        self.products = np.zeros((blocks, columns, columns))
        self.scores = np.zeros((blocks, columns))

    def add(self, J: Array, residual: Array, time: Array) -> None:
        """Adds instants of several rows each: J (T, rows, P) of the first P columns, residual (T, rows), rising time (T,), s."""
        width, blocks = J.shape[-1], len(self.scores)
        block = np.clip((time - self._first) // self._length, 0, blocks - 1).astype(int)
        edges = np.searchsorted(block, np.arange(blocks + 1))
        for b in np.unique(block):
            flat = J[edges[b] : edges[b + 1]].reshape(-1, width)
            self.products[b, :width, :width] += flat.T @ flat
            self.scores[b, :width] += residual[edges[b] : edges[b + 1]].ravel() @ flat


@dataclass(frozen=True)
class _Columns:
    """Order of a step's vector: offset, skew in SKEW_SCALE, delay, geometry, fv, parameters of each cable, of the arm."""

    geometry: slice
    fv: slice
    cables: slice
    arm: slice

    @classmethod
    def of(cls, unknowns: ClockUnknowns, arm: ArmRows | None) -> "_Columns":
        """The columns of these unknowns; without rows of the arm there are none of its own."""
        m = len(unknowns.fv)
        fv = 3 + len(unknowns.geometry_errors)
        cables = fv + m
        last = cables + unknowns.cable_parameters.size
        count = 0 if arm is None else m + arm.by_nuisance.shape[-1]
        return cls(slice(3, fv), slice(fv, cables), slice(cables, last), slice(last, last + count))

    @property
    def count(self) -> int:
        """How many columns there are."""
        return self.arm.stop

    def vector(self, unknowns: ClockUnknowns) -> Array:
        """The unknowns as a vector (P,)."""
        return np.concatenate(
            [
                [unknowns.offset, unknowns.skew / SKEW_SCALE, unknowns.delay],
                unknowns.geometry_errors,
                unknowns.fv,
                unknowns.cable_parameters.ravel(),
                unknowns.arm_parameters[: self.arm.stop - self.arm.start],
            ]
        )

    def moved(self, unknowns: ClockUnknowns, vector: Array) -> ClockUnknowns:
        """The unknowns with the numbers of a vector (P,)."""
        return replace(
            unknowns,
            offset=float(vector[0]),
            skew=float(SKEW_SCALE * vector[1]),
            delay=float(vector[2]),
            geometry_errors=vector[self.geometry],
            fv=vector[self.fv],
            cable_parameters=vector[self.cables].reshape(unknowns.cable_parameters.shape),
            arm_parameters=vector[self.arm] if self.arm.stop > self.arm.start else unknowns.arm_parameters,
        )

    def of_arm(self, rows: ArmRows, law: CableTerms) -> Array:
        """Columns of the arm's equation, (K, N, P); it holds no skew, and of the cables' parameters the forms of friction only."""
        skew = np.zeros(rows.by_offset.shape)
        shape, motors = rows.by_offset.shape, rows.by_form.shape[2]
        cables = np.zeros((*shape, motors, len(law.names)))
        if law.friction_forms:
            cables[..., law.form_columns] = FORCE_SCALE_N * rows.by_form
        cables = cables.reshape(*shape, -1)
        common = np.stack([rows.by_offset, skew, rows.by_delay], axis=-1)
        return np.concatenate([common, rows.by_geometry, rows.by_fv, cables, rows.by_fs, rows.by_nuisance], axis=-1)


def _with_torque_errors(unknowns: ClockUnknowns, arm: ArmRows, law: CableTerms) -> tuple[ClockUnknowns, Array, Array]:
    """The unknowns with parameters and errors of the arm's equation, its residuals (K, N), N m, and what whitens them, (K, N, N).

    A motor whose force is not what the log says turns all joints at once, by its cable's levers: what that leaves is no error of
    the joints."""
    k, n, m = arm.by_force.shape
    if not len(unknowns.arm_parameters):
        unknowns = replace(unknowns, arm_parameters=np.zeros(m + arm.by_nuisance.shape[-1]))
    residual = arm.residual_at(unknowns, _forms(unknowns, arm, law))
    if not np.any(unknowns.arm_parameters):
        # the residual is mostly friction
        whitening = np.broadcast_to(np.eye(n) / _FIRST_TORQUE_ERROR, (k, n, n))
        return replace(unknowns, torque_misfit=_FIRST_TORQUE_ERROR), residual, whitening
    of_joint = np.eye(n)
    in_class = _classes(residual, arm.may_be_held)
    factors = np.concatenate([of_joint * ~in_class[:, None], of_joint * in_class[:, None], arm.by_force], axis=2)
    least = np.concatenate([np.tile(unknowns.noise_scale * arm.error_by_noise, 2), np.full(m, _LEAST_FORCE_ERROR_N)])
    size = unknowns.torque_errors
    if not len(size):
        size = np.concatenate([np.tile(np.std(residual, axis=0), 2), np.ones(m)])
    source = np.arange(len(size))
    size = likelier_sizes(residual, factors, source, np.maximum(size, least), least, _ERROR_STEPS)
    root = np.linalg.cholesky(covariance_of(factors, source, size))
    misfit = float(np.exp(np.mean(np.log(np.diagonal(root, axis1=1, axis2=2)))))
    whitening = np.asarray(np.linalg.inv(root), dtype=float)
    return replace(unknowns, torque_errors=size, torque_misfit=misfit), residual, whitening


def _forms(unknowns: ClockUnknowns, arm: ArmRows, law: CableTerms) -> Array:
    """Weights of friction's forms as the arm's equation takes them, N."""
    if not law.friction_forms:
        return np.zeros(arm.by_form.shape[2:])
    return FORCE_SCALE_N * unknowns.cable_parameters[:, law.form_columns]


def _classes(residual: Array, held: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Rows (K, N) in which the joint may be held, as a class: none where these do not leave more than others, or are few."""
    out = np.zeros_like(held)
    for i in range(residual.shape[1]):
        if min(held[:, i].sum(), (~held[:, i]).sum()) >= _LEAST_ROWS_OF_A_CLASS:
            out[:, i] = held[:, i] & (np.std(residual[held[:, i], i]) > np.std(residual[~held[:, i], i]))
    return out


def _prior(
    columns: _Columns,
    unknowns: ClockUnknowns,
    assumptions: ModelAssumptions,
    fv: Array,
    arm: ArmRows | None,
    skew_fixed: bool,
) -> tuple[Array, Array]:
    """What is known before: means and standard deviations of the vector, (P,) each."""
    given = ~np.isnan(fv)
    mean, sigma = np.zeros(columns.count), np.full(columns.count, np.inf)
    mean[columns.fv] = np.where(given, np.nan_to_num(fv), 0.0)
    if skew_fixed:
        mean[1], sigma[1] = unknowns.skew / SKEW_SCALE, _FIXED / SKEW_SCALE
    else:
        sigma[1] = assumptions.skew_scale * SKEW_SIGMA / SKEW_SCALE
    if arm is None:
        sigma[2], sigma[columns.geometry] = _FIXED, _FIXED
        sigma[of_pulleys(columns.geometry)] = max(_FIXED, assumptions.pulley_sigma)
        fv_sigma = np.where(given, GIVEN_FV_SIGMA * np.abs(fv), _FIXED)
    else:
        sigma[2], sigma[columns.geometry] = DELAY_SIGMA_S, geometry_sigma(columns.geometry)
        fv_sigma = np.where(given, np.maximum(GIVEN_FV_SIGMA * np.abs(fv), 1e-6), FV_SIGMA)
        sigma[columns.arm.start + len(fv) :] = assumptions.drawing_scale * arm.nuisance_sigma
    sigma[columns.fv] = np.maximum(fv_sigma, _FIXED)
    sigma[columns.cables] = np.tile(assumptions.law.prior_sigma, len(fv))
    return mean, sigma


def _add_cables(sums: _NormalSums, columns: _Columns, rows: StepRows) -> None:
    """Adds the whitened rows of the cables' equation."""
    time, cables = rows.frames.time, rows.cables
    m, k = cables.by_parameter.shape[1:]
    for begin in range(0, len(time), CHUNK_FRAMES):
        chunk = slice(begin, begin + CHUNK_FRAMES)
        by_offset, whitening = cables.by_offset[chunk], rows.whitening[chunk]
        J = np.zeros((*by_offset.shape, columns.cables.stop))
        J[..., 0] = by_offset
        J[..., 1] = by_offset * (SKEW_SCALE * (time[chunk] - rows.frames.middle))[:, None]
        J[..., 2] = cables.by_delay[chunk]
        J[..., columns.geometry] = cables.by_geometry[chunk]
        for j in range(m):
            first = columns.cables.start + j * k
            J[:, j, columns.fv.start + j] = cables.by_fv[chunk, j]
            J[:, j, first : first + k] = cables.by_parameter[chunk, j]
        sums.add(whitening @ J, np.einsum("fij,fj->fi", whitening, cables.residual[chunk]), time[chunk])
