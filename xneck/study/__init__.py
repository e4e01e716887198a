"""How often a diagnosis finds what was hidden: cases from a generator, each scored against its truth."""
