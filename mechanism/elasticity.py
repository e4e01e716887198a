"""Elastic cables: elongation (41), (42) and the three models of tension (53), (57)."""

import numpy as np

from mechanism.arm import Arm, Array
from mechanism.cable_lengths import lengths

ElasticModel = int
"""Fasquelle's number of a model of elastic cables: 1, 2 or 3"""
ELASTIC_MODELS: tuple[ElasticModel, ...] = (1, 2, 3)


def elongation(arm: Arm, alpha: Array, theta: Array) -> Array:
    """(41): x = l(alpha) - l(0) + (rd/R) theta + x0, shape (..., M), m."""
    return lengths(arm, alpha) - lengths(arm, np.zeros(arm.N)) + arm.drum * theta + arm.x0


def elongation_rate(arm: Arm, jacobian: Array, alpha_d: Array, theta_d: Array) -> Array:
    """(42): x' = -Z^T alpha' + (rd/R) theta', shape (..., M), m/s; jacobian is Z, shape (..., N, M), m."""
    return arm.drum * theta_d - np.einsum("...ij,...i->...j", jacobian, alpha_d)


def strain_scale(arm: Arm, alpha: Array, model: ElasticModel) -> Array:
    """What x is multiplied by before the stiffness: 1 (model 1), S / l_total (model 2), S / l(alpha) (model 3).

    The stiffness that goes with it is k in N/m (model 1) or Young's modulus E in Pa. Shape (..., M).
    """
    if model == 1:
        return np.ones(())
    if model == 2:
        return arm.section / arm.cable_length
    return arm.section / lengths(arm, alpha)
