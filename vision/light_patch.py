"""The rectangle of the picture in which a light that the controller switches is seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.shutter import Shutter
from xneck_foundation.errors import Refused


@dataclass(frozen=True)
class LightPatch:
    """Pixels x..x + width, y..y + height of the upright picture."""

    x: int
    y: int
    width: int
    height: int

    def brightness(self, grey: NDArray[np.uint8]) -> float:
        """Mean grey level of the rectangle."""
        return float(grey[self.y : self.y + self.height, self.x : self.x + self.width].mean())

    def refuse_outside(self, width: int, height: int, where: str) -> None:
        """Raises Refused where the rectangle leaves a picture of this size, px."""
        if min(self.width, self.height) < 1:
            raise Refused(where, f"anchor: the rectangle is {self.width}x{self.height} px", "give a width and a height")
        if self.x + self.width > width or self.y + self.height > height:
            raise Refused(
                where,
                f"anchor: the rectangle reaches ({self.x + self.width}, {self.y + self.height}), the picture is "
                f"{width}x{height}",
                "give x, y, width, height in px of the upright picture",
            )

    def delay_s(self, height: int, shutter: Shutter) -> float:
        """By how much the rectangle's middle is exposed after the picture's middle row, s."""
        return shutter.row_s * (self.y + (self.height - 1) / 2 - (height - 1) / 2)
