"""Couples of the arm and tensions of the cables by Fasquelle's identified models, beside those measured (figures 6, 7, 8)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.dataset.dataset import DataSet
from identification.fasquelle.method import FasquelleIdentification, elastic_tension, fasquelle_regressors
from mechanism.elasticity import ElasticModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reconstruction:
    """Couples of each joint (S, N), N m, and tensions of each cable (S, M), N, at the S samples of Fasquelle's series."""

    time: Array
    """(S,), s"""
    couple_measured: Array
    """Z f from the logged forces"""
    couple_without_friction: Array
    """M alpha'' + c + g + Z Ia (R/rd) theta'': (51) with neither friction"""
    couple_dry: Array
    couple_dry_and_viscous: Array
    tension_from_force: Array
    """f - friction - Ia (R/rd) theta'', the friction being that identified alone"""
    tension_elastic: dict[ElasticModel, Array]

    def tension_error(self, model: ElasticModel) -> Array:
        """Tension of an elastic model less that from the forces, (S, M), N."""
        return self.tension_elastic[model] - self.tension_from_force


def reconstruct(data: DataSet, identification: FasquelleIdentification) -> Reconstruction:
    """Fasquelle's figures 6, 7 and 8 as numbers, for one recording and an identification of the same arm."""
    r = fasquelle_regressors(data.arm, data.fasquelle)
    f = data.fasquelle.matrix("f")

    def couple(forces: Array) -> Array:
        return np.einsum("sij,sj->si", r.Z, forces)

    frictionless = r.arm_load + couple(f - r.pull)
    fs = identification.dry_only.values("fs")
    both = r.dry * identification.dry_and_viscous.values("fs") + r.theta_d * identification.dry_and_viscous.values("fv")
    return Reconstruction(
        time=data.fasquelle.time,
        couple_measured=couple(f),
        couple_without_friction=frictionless,
        couple_dry=frictionless + couple(r.dry * fs),
        couple_dry_and_viscous=frictionless + couple(both),
        tension_from_force=r.pull - r.dry * fs,
        tension_elastic={model: elastic_tension(r, model, fit) for model, fit in identification.elastic.items()},
    )
