"""Worlds that tests and benchmarks share: recordings drawn at random, given as the arrays that the stages take."""
