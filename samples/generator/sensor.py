"""From light to grey levels: vignette, lens blur, noise, quantisation.

The sensor is linear: a reflectance of 1 under a light of 1 is grey level 255.
"""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from samples.generator.camera import Camera

FloatImage = NDArray[np.float32]


def expose(light: FloatImage, camera: Camera, rng: np.random.Generator | None) -> NDArray[np.uint8]:
    """Grey levels of the mean light on each pixel, shape (h, w) or (h, w, 3); no noise where `rng` is None."""
    levels = 255.0 * light
    if camera.psf_sigma_px > 0:
        reach = int(np.ceil(5 * camera.psf_sigma_px))
        levels = cv2.GaussianBlur(levels, (2 * reach + 1, 2 * reach + 1), camera.psf_sigma_px)
    dark = vignette(camera)
    levels = levels * (dark[..., None] if levels.ndim == 3 else dark)
    if rng is not None:
        # one draw for all colours: noise of the colours would cost the encoder more than the whole arm
        draw = rng.standard_normal(levels.shape[:2], dtype=np.float32)
        grey = levels.mean(axis=-1) if levels.ndim == 3 else levels
        draw *= np.sqrt(np.float32(camera.read_noise**2) + np.float32(camera.shot_noise) * grey)
        levels = levels + (draw[..., None] if levels.ndim == 3 else draw)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


@lru_cache(maxsize=4)
def vignette(camera: Camera) -> FloatImage:
    """Share of the light that arrives, shape (h, w)."""
    v, u = np.mgrid[0 : camera.height, 0 : camera.width]
    r2 = (u - camera.cx) ** 2 + (v - camera.cy) ** 2
    return (1 - camera.vignette * r2 / r2.max()).astype(np.float32)
