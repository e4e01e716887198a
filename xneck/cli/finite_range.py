"""Numbers of options."""

import math
from typing import Any

import click


class FiniteRange(click.FloatRange):
    """A number within a range; click's own takes `nan` for one within any, and infinity where there is no upper end."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is no number that can be computed with.", param, ctx)
        return number
