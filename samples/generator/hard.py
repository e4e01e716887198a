"""Short recordings that are hard to measure: things across the markers, blur, shadow, glare; their truth is given.

from samples.generator.hard import cases
case = cases(neck)["cable"]; case.render("cable.mp4")
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from samples.generator.camera import SAMPLE_CAMERA, Camera
from samples.generator.frame import plates
from samples.generator.scene import EDGE, Shape
from samples.generator.trouble import NONE, Glare, Trouble
from samples.generator.video import Look, render_video

Array = NDArray[np.float64]

FRAMES = 60
FRAME_HZ = 30.0
CABLE = 0.002
"""m: 4 px where a marker has 60"""
COMES_AT = 0.3
"""s; until then nothing is in the way, as when a recording is begun"""
GREY = (0.30, 0.30, 0.31)
CAMERA = replace(SAMPLE_CAMERA, width=840, cx=SAMPLE_CAMERA.cx - 220)
"""the sample's camera, its picture narrowed to the arm: a marker is 60 px wide"""
FAST = replace(CAMERA, exposure_s=0.020)
PORTRAIT = replace(CAMERA, width=720, height=840, cx=SAMPLE_CAMERA.cx - 280, cy=SAMPLE_CAMERA.cy + 60)


@dataclass(frozen=True)
class Hard:
    """One recording; `alpha_at` is its truth."""

    neck: dict[str, Any]
    """the contents of neck.yaml"""
    alpha_at: Callable[[float], Array]
    """joint angles (N,), rad, at a time of the camera's clock"""
    trouble_at: Callable[[float], Trouble]
    camera: Camera = CAMERA
    instants: int = 5
    turned: bool = False
    """stored on its side, with a tag"""

    @property
    def times(self) -> Array:
        """Middles of the exposures, s."""
        return np.arange(FRAMES) / FRAME_HZ

    def truth(self, frames: int = FRAMES) -> Array:
        """The joint angles of the first frames, (frames, N), rad."""
        return np.array([self.alpha_at(t) for t in self.times[:frames]])

    def render(self, path: str | Path, frames: int = FRAMES, seed: int = 1) -> None:
        """Write the first frames as a video."""
        render_video(
            path,
            self.times[:frames],
            self.alpha_at,
            self.neck,
            self.camera,
            seed,
            Look(instants=self.instants),
            trouble_at=self.trouble_at,
            turned=self.turned,
        )


def cases(neck: dict[str, Any]) -> dict[str, Hard]:
    """All of them by name, for an arm of three mechanisms with a marker on the middle of every bar."""
    on_bars = neck["markers"]["on_bars"]
    # bar 2 has none of its own; these stand upright in the rest pose
    leaning = [{"id": 4, "diagonal": "A2", "angle": -np.pi / 3}, {"id": 5, "diagonal": "B3", "angle": -2 * np.pi / 3}]
    others = [on for on in on_bars if on["bar"] != 2]
    diagonal = neck | {"markers": neck["markers"] | {"on_bars": others + leaning}}
    return {
        "nothing in the way": Hard(neck, swing, lambda t: NONE),
        "cable": Hard(neck, swing, _cable(neck, swing, COMES_AT)),
        "cable from the start": Hard(neck, swing, _cable(neck, swing, 0.0)),
        "a quarter hidden": Hard(neck, swing, _quarter(neck, swing, COMES_AT)),
        "hidden from the start": Hard(neck, swing, _quarter(neck, swing, 0.0)),
        "6 px of blur": Hard(neck, quick, lambda t: NONE, FAST, instants=12),
        "6 px of blur, cable": Hard(neck, quick, _cable(neck, quick, COMES_AT), FAST, instants=12),
        "19 px of blur": Hard(neck, rush, lambda t: NONE, FAST, instants=20),
        "hard shadow": Hard(neck, swing, _shadow),
        "glare": Hard(neck, swing, _glare),
        "cable, on diagonals": Hard(diagonal, swing, _cable(diagonal, swing, COMES_AT)),
        "cable, portrait": Hard(neck, swing, _cable(neck, swing, COMES_AT), PORTRAIT, turned=True),
    }


def swing(t: float) -> Array:
    """The sample's kind of motion."""
    return np.radians([12 * np.sin(3.1 * t), 14 * np.sin(4.3 * t + 1.0), 16 * np.sin(5.2 * t + 2.0)])


def quick(t: float) -> Array:
    """In 20 ms the uppermost marker moves by 6 px on an average, by up to 10."""
    return np.radians([16 * np.sin(5.0 * t + 5.6), 8 * np.sin(6.1 * t + 1.4), 9 * np.sin(7.0 * t + 3.9)])


def rush(t: float) -> Array:
    """In 20 ms the uppermost marker moves by up to 19 px, more than two of its cells."""
    return np.radians([16 * np.sin(5.0 * t), 14 * np.sin(6.1 * t + 0.6), 12 * np.sin(7.0 * t + 1.0)])


def _cable(neck: dict[str, Any], alpha_at: Callable[[float], Array], from_s: float) -> Callable[[float], Trouble]:
    """A thin dark cable that hangs before every marker but the base's, and sways to and fro over them."""

    def trouble(t: float) -> Trouble:
        if t < from_s:
            return NONE
        laid = plates(alpha_at(t), neck)
        line = [
            plate.place + 0.010 * np.sin(2.3 * t + 1.9 * k) * np.exp(1j * plate.angle)
            for k, plate in enumerate(sorted(laid[1:], key=lambda plate: plate.place.imag))
        ]
        ends = [line[0] - 0.05 - 0.03j, *line, line[-1] + 0.01 + 0.08j]
        return Trouble(in_front=(Shape(np.array(ends), EDGE, CABLE),))

    return trouble


def _quarter(neck: dict[str, Any], alpha_at: Callable[[float], Array], from_s: float) -> Callable[[float], Trouble]:
    """Grey strips a quarter of a marker wide that go over all markers but the base's, from side to side and back."""

    def trouble(t: float) -> Trouble:
        if t < from_s:
            return NONE
        size = float(neck["markers"]["size"])
        shapes = []
        for k, plate in enumerate(plates(alpha_at(t), neck)[1:]):
            at = 0.375 * size * np.sin(1.7 * t + 1.3 * k)  # its middle, never beyond the square's side
            x, y = at + size / 8 * np.array([-1, 1, 1, -1]), 0.8 * size * np.array([-1, -1, 1, 1])
            shapes.append(Shape(plate.place + np.exp(1j * plate.angle) * (x + 1j * y), GREY))
        return Trouble(in_front=tuple(shapes))

    return trouble


def _shadow(t: float) -> Trouble:
    """Of a straight edge, across the picture at a slant, slowly moving: a third of the light is left."""
    x = -0.01 + 0.02 * np.sin(1.1 * t)
    edge = np.array([x - 0.03 - 0.1j, x + 0.03 + 0.35j])
    outline = np.concatenate([edge, [0.6 + 0.35j, 0.6 - 0.1j]])
    return Trouble(shadows=(Shape(outline, (0.33, 0.33, 0.33)),))


def _glare(t: float) -> Trouble:
    """A lamp in the gloss of the upper markers."""
    return Trouble(
        glare=(Glare(0.015 + 0.17j, 0.008, 1.1), Glare(-0.01 + 0.255j, 0.008, 1.1), Glare(0.08j, 0.006, 1.1))
    )
