"""Model of the grey levels of printed markers: their templates under a plane of light on black and one on white.

The parameters are the columns of the least squares: the marker's motion (eight numbers, `planar_motion`), changes of blur and
ink bleed, and the light.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.markers.edge_pixels import EdgePixels
from vision.markers.planar_motion import DOF
from vision.markers.template import sample_texture
from vision.markers.tone_curve import through_tone_curve

Array = NDArray[np.float64]
Single = NDArray[np.float32]

BLUR_VARIANCE, INK_BLEED, LIGHT = DOF, DOF + 1, slice(DOF + 2, DOF + 8)
"""columns after the motion: the blur's variance, the ink bleed, and the light: 1, u, v times black and white, then white alone"""
COLUMNS = DOF + 8
WHITE = DOF + 5
"""column of white's level over black"""
LIGHT_SLOPES = [DOF + 3, DOF + 4, DOF + 6, DOF + 7]
UNKNOWN_LIGHT = np.full(6, np.nan)
DARK = 0.15
"""template's value, from black (0) to white (1), below which a pixel shows the level of black; white's likewise"""
DARKEST_SHARE = 0.1
"""of the pixels that show black where fewer are below DARK"""
MIN_LEVEL_PIXELS = 20
"""pixels of black or of white, below which their level is not taken"""


@dataclass(frozen=True)
class MarkerTemplates:
    """The markers' textures at the pixels of M markers."""

    u: Single
    """(M, N), marker coordinates"""
    v: Single
    """(M, N), marker coordinates"""
    channels: Single
    """(M, 5, N): as `Texture` has them"""

    @classmethod
    def of(cls, pixels: EdgePixels, H: Array) -> "MarkerTemplates":
        """The templates seen through the homographies H (M, 3, 3)."""
        u, v = pixels.marker_coordinates(np.linalg.inv(H).astype(float))
        channels = np.empty((len(H), 5, u.shape[1]), dtype=np.float32)
        for k, texture in enumerate(pixels.textures):
            channels[k] = through_tone_curve(sample_texture(texture, u[k], v[k]), pixels.tone)
        return cls(u, v, channels)

    def under(self, light: Array) -> Single:
        """Grey levels under light (M, 6), (M, N)."""
        b0, bu, bv, w0, wu, wv = light.astype(np.float32).T[..., None]
        return b0 + bu * self.u + bv * self.v + (w0 + wu * self.u + wv * self.v) * self.channels[:, 0]


def initial_light(templates: MarkerTemplates, pixels: EdgePixels, light: Array) -> Array:
    """Light (M, 6); where it is not known, from the median levels of the pixels that should be darkest and brightest."""
    light = light.copy()
    for k in np.flatnonzero(np.isnan(light[:, 0])):
        used = pixels.used[k]
        value, grey = templates.channels[k, 0][used], pixels.grey[k][used]
        low, high = (0.0, 0.0) if not len(value) else np.quantile(value, (DARKEST_SHARE, 1 - DARKEST_SHARE))
        # small cells are nowhere quite black or white
        dark, bright = value < max(DARK, float(low)), value > min(1 - DARK, float(high))
        contrast, black = 1.0, 0.0
        if min(np.count_nonzero(dark), np.count_nonzero(bright)) >= MIN_LEVEL_PIXELS:
            (v0, g0), (v1, g1) = ((float(np.median(value[m])), float(np.median(grey[m]))) for m in (dark, bright))
            contrast = max((g1 - g0) / max(v1 - v0, DARK), 1.0)
            black = g0 - contrast * v0
        light[k] = [black, 0.0, 0.0, contrast, 0.0, 0.0]
    return light


def model_derivatives(templates: MarkerTemplates, grey: Single, light: Array) -> Single:
    """The model's derivatives by all columns under light (M, 6), and last the grey levels, (M, COLUMNS + 1, N)."""
    u, v = templates.u, templates.v
    value, by_u, by_v, by_variance, by_bleed = templates.channels.transpose(1, 0, 2)
    D = np.empty((len(u), COLUMNS + 1, u.shape[1]), dtype=np.float32)
    w0, wu, wv = light[:, 3:].astype(np.float32).T[..., None]
    white = w0 + wu * u + wv * v
    np.multiply(by_variance, white, out=D[:, BLUR_VARIANCE])
    np.multiply(by_bleed, white, out=D[:, INK_BLEED])
    np.negative(white, out=white)
    a, b = np.multiply(by_u, white, out=D[:, 0]), np.multiply(by_v, white, out=D[:, 1])
    # the unit displacements of `planar_motion`, times the template's slopes
    np.multiply(a, u, out=D[:, 2])
    np.multiply(a, v, out=D[:, 3])
    np.multiply(b, u, out=D[:, 4])
    np.multiply(b, v, out=D[:, 5])
    radial = D[:, 2] + D[:, 5]
    np.multiply(radial, u, out=D[:, 6])
    np.multiply(radial, v, out=D[:, 7])
    D[:, LIGHT.start], D[:, LIGHT.start + 1], D[:, LIGHT.start + 2], D[:, WHITE] = 1.0, u, v, value
    np.multiply(value, u, out=D[:, WHITE + 1])
    np.multiply(value, v, out=D[:, WHITE + 2])
    D[:, COLUMNS] = grey
    return D
