"""Diagnoses of short generated recordings with known truth, once as they are and once with each threshold changed."""

import importlib
import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from unittest.mock import patch

from benchmarks.thresholds.outcome import Outcome
from benchmarks.thresholds.room import Room
from benchmarks.thresholds.threshold import Threshold, scaled
from diagnosis import cause_choice, cause_search, look_alikes, record, worth_naming
from diagnosis.cause_fit import CauseFitter
from diagnosis.noise_ensemble import noise_ensemble
from identification.dataset.dataset_file import read_dataset, write_dataset
from samples.generator.hidden.experiment import RECORDINGS, hide
from xneck.recording.stages import synchronise_recording
from xneck.study.plan import Case as StudyCase
from xneck.study.score import score_case
from xneck_foundation.errors import Refused

stage = importlib.import_module("diagnosis.diagnose")
"""the module; the package may hold a function of that name"""

SECONDS = (20.0, 20.0)
SMALL, TINY = 0.5, 0.2
"""sizes of effects, 1 being the study's: thresholds matter where effects are small"""


@dataclass(frozen=True)
class Case:
    """What is hidden in a pair of recordings, of which size, and how far the drawing is off at most."""

    kinds: tuple[str, ...] = ()
    size: float = 1.0
    drawing: float = 0.01


CASES: dict[int, Case] = {
    7300: Case(),
    7301: Case(("tip_payload",), SMALL),
    7302: Case(("spring_stiffness",), SMALL),
    7303: Case(("stribeck_friction",), SMALL),
    7304: Case(("cogging",)),
    7305: Case(("drum_radius",), SMALL),
    7306: Case(("cable_hardening",), SMALL),
    7307: Case(("marker_offset",), SMALL),
    7308: Case(),
    7309: Case(("viscous_friction",), SMALL),
    7310: Case(("warming_friction",)),
    7311: Case(("actuator_offset",), SMALL),
    7312: Case(("pulley_friction",), SMALL),
    7313: Case(("cable_creep",), SMALL),
    7314: Case(("base_tilt", "cable_hysteresis")),
    7315: Case(),
    7316: Case(("outside_force",)),
    7317: Case(("tip_payload", "viscous_friction")),
    7320: Case(drawing=0.02),
    7321: Case(("tip_payload",), TINY),
    7322: Case(("cogging",), 0.3),
    7323: Case(("pulley_friction",), TINY),
    7324: Case(("joint_friction",), 0.3),
    7325: Case(drawing=0.03),
    7326: Case(("base_tilt",), TINY),
    7327: Case(("actuator_gain",), TINY),
    7328: Case(("warming_friction",), 0.3),
    7329: Case(("backlash", "spring_stiffness"), SMALL),
    7330: Case(("cable_slack",), SMALL),
    7331: Case(("actuator_lag", "cable_creep"), SMALL),
}
"""by seed, none of which was ever used for setting anything"""
OUTSIDE = {"cogging": "periodic", "warming_friction": "drift", "outside_force": "episodes"}
"""effects of no catalogue, and the signature that they should have"""


@dataclass(frozen=True)
class World:
    """A pair of data sets with their truth."""

    seed: int
    folder: Path

    @property
    def name(self) -> str:
        """Such as `7301 tip_payload`."""
        return f"{self.seed} {'+'.join(self.kinds) or 'none'}"

    @property
    def kinds(self) -> tuple[str, ...]:
        return CASES[self.seed].kinds

    @property
    def size(self) -> float:
        return CASES[self.seed].size

    @cached_property
    def data(self) -> tuple[Any, Any]:
        """The data set that is fitted, and the one that is held out; made once, kept in the folder."""
        here = self.folder / str(self.seed)
        if not (here / "done").exists():
            shutil.rmtree(here, ignore_errors=True)
            hide(self.kinds, self.seed, here, seconds=SECONDS, size=self.size, cad=CASES[self.seed].drawing)
            for name in RECORDINGS:
                write_dataset(synchronise_recording(here / name), here / f"{name}.mcap")
            (here / "done").touch()
        fitted, held_out = (read_dataset(here / f"{name}.mcap") for name in RECORDINGS)
        return fitted, held_out

    @cached_property
    def truth(self) -> dict[str, Any]:
        return json.loads((self.folder / str(self.seed) / "truth.json").read_text(encoding="utf-8"))


def worlds(folder: Path) -> list[World]:
    """All of them; the folder of the recordings is common to all rooms of diagnosis."""
    return [World(seed, folder.parent / "recordings") for seed in CASES]


def judged(world: World) -> Outcome:
    """The diagnosis as it is now against the truth."""
    fitted, held_out = world.data
    try:
        found = stage.diagnose([fitted], [held_out])
    except Refused as refusal:
        return Outcome(False, False, f"refused: {refusal}")
    case = StudyCase(world.kinds, world.seed, "rich", world.size, 0.1, SECONDS)
    result = {"name": world.name, "case": case.as_json(), "truth": world.truth, "diagnosis": record.as_json(found)}
    own = score_case(result)
    said = f"{found.verdict}: " + ", ".join(f"{c.effect.name} {c.where.label}" for c in found.causes)
    said += f" | signature {found.signature.kind}"
    right = own.right and all(s.place is not False for s in own.sightings)
    return Outcome(right, bool(own.false), said.strip())


def judged_signature(world: World) -> Outcome:
    """The signature of an effect of no catalogue."""
    fitted, held_out = world.data
    found = stage.diagnose([fitted], [held_out])
    wanted, kind = OUTSIDE[world.kinds[0]], found.signature.kind
    return Outcome(kind == wanted, kind not in (wanted, "unclear", "nothing"), kind)


def _memo(function: Callable[..., Any], key: Callable[..., Any]) -> Callable[..., Any]:
    """The function, which keeps what it gave; the key holds every constant that it reads."""
    known: dict[Any, Any] = {}
    kept: list[Any] = []

    def asked(*args: Any) -> Any:
        which = key(*args)
        if which not in known:
            known[which] = function(*args)
            kept.append(args)  # so that no other object gets one of these ids
        return known[which]

    return asked


def _constants(*modules: str) -> tuple[Any, ...]:
    """Values of the modules' constants as they are now."""
    held = (vars(importlib.import_module(f"diagnosis.{module}")) for module in modules)
    return tuple((k, v) for each in held for k, v in each.items() if k.isupper() and isinstance(v, int | float))


@contextmanager
def noise_kept() -> Iterator[None]:
    """Draws of noise of a data set are made once; the simulation, on which no verdict rests, is left out."""
    with ExitStack() as stack:
        once = _memo(noise_ensemble, lambda data, frames, seed: (id(data), seed, _constants("noise_ensemble")))
        stack.enter_context(patch.object(stage, "noise_ensemble", once))
        stack.enter_context(patch.object(stage, "simulated_gains", lambda *models: ()))
        stack.enter_context(patch.object(stage, "simulated_shares", lambda *of: ()))
        stack.enter_context(patch.object(stage, "arm_error", lambda *of: None))
        yield


def _at_whitened(at: Any, whiten: Any) -> tuple[int, int]:
    return id(at), id(whiten)


@contextmanager
def fits_kept() -> Iterator[Callable[[], None]]:
    """Fits of the same causes to the same data are made once: for thresholds that do not enter fits.

    Gives a function that forgets what such a threshold may change in them."""
    fitters: dict[tuple[int, ...], CauseFitter] = {}
    stages: list[Any] = []

    class KeptFitter(CauseFitter):
        def fitted(self, start: Any, causes: Any, to_beat: float = float("inf")) -> Any:
            stages.append(super().fitted(start, causes, to_beat))
            return stages[-1]

        reweighted = _memo(CauseFitter.reweighted, lambda fitter, at: (id(fitter), id(at)))

    def fitter(h: Any, ensembles: Any) -> CauseFitter:
        which = tuple(id(one) for one in ensembles)
        if which not in fitters:
            fitters[which] = KeptFitter(h, ensembles)
        return fitters[which]

    def forget() -> None:
        for each in stages:
            each.__dict__.pop("possible", None)

    shown = ("signature", "residual_episodes", "residual_conditions", "drum_periodogram", "explained_energy")
    memos: tuple[tuple[Any, str, Callable[..., Any]], ...] = (
        *((module, "with_effects", _at_whitened) for module in (cause_search, cause_choice, look_alikes)),
        (cause_search, "rank", lambda at: (id(at), worth_naming.SINGLE_PLACE_SHARE, worth_naming.SIMPLER_SHARE)),
        (
            stage,
            "held_out_residuals",
            lambda at, others, whiten, relaxed: (id(at.comparison), at.before_causes.held, id(whiten), relaxed),
        ),
        (stage, "detectability", lambda found: (id(found.every_effect), id(found.last), _constants("detectability"))),
        (stage, "signature", lambda first, last: (id(first), id(last), _constants(*shown))),
    )
    with noise_kept(), ExitStack() as stack:
        stack.enter_context(patch.object(cause_search, "CauseFitter", fitter))
        for module, name, key in memos:
            stack.enter_context(patch.object(module, name, _memo(getattr(module, name), key)))
        yield forget


def _thresholds() -> list[Threshold]:
    """Those that decide what is named and said, and enter no fit."""
    worth, alike, excess = "diagnosis.worth_naming", "diagnosis.look_alikes", "diagnosis.noise_excess"
    return [
        *scaled(worth, "MIN_LOSS_SHARE", "MIN_EXPLAINED_NEXT", "SIMPLER_SHARE", "TIE_BY_CHANCE"),
        *scaled("diagnosis.cause_choice", "CHANCE_LEVEL"),
        *scaled(alike, "_MAX_RIVALS"),
        Threshold(worth, "MIN_EXPLAINED", 0.8, 0.2),
        Threshold(worth, "SINGLE_PLACE_SHARE", 0.975, 0.9),
        Threshold(alike, "_RIVAL_SHARE", 0.85, 0.4),
        Threshold("diagnosis.remainder", "MAX_REMAINDER", 1.25, 2.0),
        Threshold(excess, "ABOVE_NOISE_RATIO", 1.125, 1.5),
        *scaled("diagnosis.fit_stage", "IMPOSSIBLE_SIGMAS"),
        *scaled("diagnosis.diagnose", "TOO_MANY_TIED", "MAX_INVISIBLE_SHARE"),
        *scaled("diagnosis.findings", "_WORSE_SIGMAS"),
        *scaled("diagnosis.detectability", "_VISIBLE_SIZE"),
    ]


def _fit_thresholds() -> list[Threshold]:
    """Those that enter fits: what is known beforehand, and what counts as noise."""
    return [
        *scaled("diagnosis.noise_ensemble", "_WHITE_SHARE"),
        *scaled("diagnosis.comparison", "FOLD_BLOCK_S", "_TELLING_SHARE"),
        *scaled("identification.unknowns", "DELAY_SIGMA_S"),
        *scaled("diagnosis.cause_fit", "MAX_START_DELAY_S"),
        Threshold("diagnosis.comparison", "FOLDS", 3, 10),
        *scaled("diagnosis.judged_rows", "ARM_CUTOFF_HZ"),
    ]


def _signature_thresholds() -> list[Threshold]:
    return [
        *scaled("diagnosis.signature", "FALSE_ALARM", "_MIN_EXPLAINED", "_MIN_EXPLAINED_BESIDE_EPISODES"),
        Threshold("diagnosis.signature", "_CONSTANT_SHARE", 0.975, 0.9),
        Threshold("diagnosis.residual_episodes", "MIN_EPISODE_SHARE", 0.9, 0.6),
        Threshold("diagnosis.residual_episodes", "_LISTED_SHARE", 0.95, 0.8),
        *scaled("diagnosis.residual_episodes", "MAX_TIME_SHARE", "WINDOW_S"),
        *scaled("diagnosis.residual_conditions", "BINS"),
        *scaled("diagnosis.drum_periodogram", "_MAX_PER_MOTOR_TURN"),
        *scaled("diagnosis.explained_energy", "_MAX_LAG_PART"),
        Threshold("diagnosis.noise_excess", "ABOVE_NOISE_RATIO", 1.125, 1.5),
    ]


ROOM = Room("diagnosis", worlds, judged, _thresholds, fits_kept)
FITS = Room("diagnosis_fits", worlds, judged, _fit_thresholds, noise_kept)
SIGNATURES = Room(
    "signature",
    lambda folder: [world for world in worlds(folder) if OUTSIDE.keys() & set(world.kinds)],
    judged_signature,
    _signature_thresholds,
    fits_kept,
)
