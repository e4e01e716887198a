"""Mutants that nobody could notice, each with its reason: by the function and the line as the mutant has it."""

_CROSSING = "crossing = np.where(np.sign(at.travel_d) * side {} 1 - _FLANK, self.memory_rate(p, at, {})[..., 0], 0.0)"

EQUIVALENT: dict[tuple[str, str], str] = {
    (
        "mechanism.laws.backlash.Backlash.pull",
        _CROSSING.format("<=", "z"),
    ): "differs on a flank that is reached to a thousandth and to the last bit",
    (
        "mechanism.laws.backlash.Backlash.pull",
        _CROSSING.format("<", "None"),
    ): "how fast play is crossed does not depend on where in it the drum is",
    (
        "mechanism.laws.unlisted.UnlistedLaw._made",
        "constants = cast(None, {name: p[self.term_name(name)] for name in self.form.constants})",
    ): "a cast is for type checkers",
    (
        "mechanism.laws.actuator_lag.ActuatorLag.acting_force",
        "for i, d in zip(np.ndindex(batch), np.broadcast_to(decay[..., 0], (*batch, 1)).reshape(-1), strict=None):",
    ): "both are as long by construction",
    (
        "mechanism.laws.actuator_lag.ActuatorLag.acting_force",
        "for i, d in zip(np.ndindex(batch), np.broadcast_to(decay[..., 0], (*batch, 1)).reshape(-1), strict=False):",
    ): "both are as long by construction",
    (
        "mechanism.laws.unlisted.UnlistedLaw.values",
        "named = {self.term_name(name): a for name, a in zip(self.form.amounts, amounts, strict=False)}",
    ): "both are as long by construction",
}
