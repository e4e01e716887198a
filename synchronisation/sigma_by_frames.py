"""Sigma of angles that come without one: what they scatter by from frame to frame."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.dataset.frames import DEFAULT_SIGMA_RAD
from synchronisation.frame_noise import FrameNoise, frame_noise

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SigmaByFrames:
    """Of angles in F frames and N joints."""

    sigma: Array
    """(F, N), rad, NaN where an angle was not seen"""
    record: dict[str, Any]
    """as `noise_record` makes it"""


def sigma_by_frames(time: Array, alpha: Array) -> SigmaByFrames:
    """Sigma of angles (F, N), rad, at camera times (F,), s.

    Where the frames cannot tell their noise, it is what they say that it is at most, and no more than DEFAULT_SIGMA_RAD.
    """
    noise = frame_noise(time, alpha, np.full(alpha.shape, DEFAULT_SIGMA_RAD))
    ratio = np.where(np.isnan(noise.ratio), np.minimum(noise.bound, 1.0), noise.ratio)
    sigma = np.maximum(ratio * DEFAULT_SIGMA_RAD, noise.outlying)
    return SigmaByFrames(
        np.where(np.isnan(alpha), np.nan, sigma), noise_record("frames", noise, ratio * DEFAULT_SIGMA_RAD)
    )


def noise_record(source: str, noise: FrameNoise, sigma: Array) -> dict[str, Any]:
    """What a data set notes of the noise of its angles: of each joint the sigma (N,), rad, that holds for most of its frames.

    source: "frames" where it was read from them, "file" where it was given; `scatter` is then true over given noise. Joints whose
    frames cannot tell have null.
    """

    def told(values: Array) -> list[float | None]:
        return [None if np.isnan(value) else float(value) for value in values]

    return {
        "from": source,
        "sigma_rad": told(sigma),
        "scatter": told(noise.ratio if source == "file" else np.where(np.isnan(noise.ratio), np.nan, 1.0)),
        "scatter_sigma": told(noise.ratio_sigma / (1.0 if source == "file" else noise.ratio)),
        "outlying_frames": np.count_nonzero(noise.outlying, axis=0).tolist(),
    }
