"""Recording folders as a lab would have them, and the truth beside them."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from samples.forward_arms.arms import Arm, Recording
from samples.forward_arms.drawing import neck
from samples.forward_arms.plant import Array
from samples.forward_arms.settings import Settings

_RECORDING = "angles: alpha.csv\nlog: log.csv\nneck: neck.yaml\n"


def write_arm(arm: Arm, folder: Path, settings: Settings) -> None:
    """folder/rec01 and so on, folder/truth.json, folder/truth_rec01.npz and so on."""
    folder.mkdir(parents=True, exist_ok=True)
    described = yaml.safe_dump(neck(arm.drawing), sort_keys=False)
    for i, recording in enumerate(arm.recordings):
        name = f"rec{i + 1:02d}"
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "neck.yaml").write_text(described, encoding="utf-8")
        (folder / name / "recording.yaml").write_text(_RECORDING, encoding="utf-8")
        _write_csvs(recording, folder / name, settings)
        _write_truth(recording, folder / f"truth_{name}.npz")
    (folder / "truth.json").write_text(json.dumps(_truth(arm, settings), indent=1), encoding="utf-8")


def _write_csvs(recording: Recording, folder: Path, settings: Settings) -> None:
    seen = recording.film
    n, m = seen.seen.shape[1], recording.theta.shape[1]
    angles, names = [seen.seen], [f"alpha{i + 1}" for i in range(n)]
    if settings.sigma_columns:
        angles.append(np.full_like(seen.seen, seen.noise))
        names += [f"sigma{i + 1}" for i in range(n)]
    _write_csv(folder / "alpha.csv", names, seen.stamp, np.hstack(angles))
    names = [f"{v}{j + 1}" for v in ("theta", "f") for j in range(m)]
    _write_csv(folder / "log.csv", names, recording.time, np.hstack([recording.theta, recording.f]))


def _write_csv(path: Path, names: list[str], time: Array, values: Array) -> None:
    header = ",".join(["time", *names])
    np.savetxt(path, np.column_stack([time, values]), "%.9f", delimiter=",", header=header, comments="")


def _write_truth(recording: Recording, path: Path) -> None:
    truth, seen = recording.truth.within_log(), recording.film
    np.savez(
        path,
        time=truth.time,
        alpha=truth.alpha,
        alpha_dot=truth.alpha_d,
        alpha_ddot=truth.alpha_dd,
        theta=truth.theta,
        theta_dot=truth.theta_d,
        tension=truth.tension,
        frame_stamp=seen.stamp,
        frame_t_log=seen.log_time,
        frame_alpha_mean=seen.mean,
    )


def _truth(arm: Arm, settings: Settings) -> dict[str, Any]:
    laws = [
        {"law": type(law).__name__} | {f.name: _plain(getattr(law, f.name)) for f in fields(law)} for law in arm.laws
    ]
    recordings = {
        f"rec{i + 1:02d}": {
            "offset": r.film.offset,
            "skew": r.film.skew,
            "exposure": r.film.exposure,
            "noise_rad": r.film.noise,
            "dropped": r.film.dropped,
            "delay": settings.delay,
            "jitter": settings.jitter,
            "peak_deg": float(np.degrees(np.abs(r.truth.alpha)).max()),
            "least_tension": float(r.truth.tension.min()),
            "greatest_tension": float(r.truth.tension.max()),
            "greatest_speed": float(np.abs(r.truth.theta_d).max()),
        }
        for i, r in enumerate(arm.recordings)
    }
    true = {f.name: _plain(getattr(arm.plant, f.name)) for f in fields(arm.plant)}
    return {"seed": arm.seed, "base": settings.base, "hidden": laws, "true": true, "recordings": recordings}


def _plain(value: Any) -> Any:
    value = np.asarray(value)
    return np.stack([value.real, value.imag], axis=-1).tolist() if np.iscomplexobj(value) else value.tolist()
