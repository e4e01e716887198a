"""Mutants that nobody could notice, each with its reason: by the function and the line as the mutant has it."""

EQUIVALENT: dict[tuple[str, str], str] = {}
