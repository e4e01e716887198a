"""What may be wrong with the model, one cause a file; `EFFECTS` holds all that modules of this folder define, by name."""

from diagnosis.effect import Effect
from xneck_foundation.class_discovery import classes_in

__all__ = ["EFFECTS"]

EFFECTS: dict[str, Effect] = {
    effect.name: effect()
    for effect in sorted(classes_in(__name__, __path__, Effect), key=lambda effect: (effect.order, effect.name))
}
