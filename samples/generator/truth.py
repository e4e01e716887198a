"""The truth behind the shipped samples: written by the generator, read by tests and by nothing else."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from samples.generator.camera import Camera
from samples.generator.recording import Recording
from samples.generator.taut_string import Array

_SERIES = ("alpha", "alpha_d", "alpha_dd", "theta", "tension")


@dataclass(frozen=True)
class Truth:
    """Of one recording; log rows T, frames F, mechanisms N, cables M."""

    scalars: dict[str, Any]
    """offset_s (at the camera's middle), skew, middle_s, and under `hidden` fs, fv, k, ca (length M), load"""
    frame_times: Array
    """shape (F,), s, camera's clock"""
    frame_alpha: Array
    """shape (F, N), rad"""
    log_time: Array
    """shape (T,), s, controller's clock"""
    alpha: Array
    """shape (T, N), rad, like the following at log_time"""
    alpha_d: Array
    """shape (T, N), rad/s"""
    alpha_dd: Array
    """shape (T, N), rad/s^2"""
    theta: Array
    """before the encoder, shape (T, M), rad"""
    tension: Array
    """shape (T, M), N"""


def write_truth(folder: Path, seed: int, recordings: dict[str, Recording], camera: Camera) -> None:
    """Their part of truth.json, and truth.npz; series as float32 (1e-7 of their size), times as float64."""
    scalars: dict[str, Any] = {"seed": seed, "camera": asdict(camera)}
    arrays: dict[str, np.ndarray] = {}
    for name, r in recordings.items():
        scalars[name] = asdict(r.clocks) | {"hidden": asdict(r.hidden)}
        arrays[f"{name}_frame_times"] = r.frame_times
        arrays[f"{name}_frame_alpha"] = r.alpha_at(r.frame_times)
        arrays[f"{name}_log_time"] = r.log_time
        for series in _SERIES:
            arrays[f"{name}_{series}"] = getattr(r.run, series).astype(np.float32)
    add_scalars(folder, scalars)
    np.savez_compressed(folder / "truth.npz", **arrays)  # type: ignore[arg-type]  # the stubs take no mapping


def add_scalars(folder: Path, scalars: dict[str, Any]) -> None:
    """Puts these keys into truth.json beside what it holds already."""
    path = folder / "truth.json"
    known = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    path.write_text(json.dumps(known | scalars, indent=1) + "\n", encoding="utf-8")


def read_truth(folder: Path, name: str) -> Truth:
    """Truth of the recording `name` ("recording" or "held_out") in the samples' folder."""
    scalars = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    with np.load(folder / "truth.npz") as arrays:
        series = {
            field: arrays[f"{name}_{field}"].astype(float)
            for field in ("frame_times", "frame_alpha", "log_time", *_SERIES)
        }
    return Truth(scalars[name], **series)
