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
}
