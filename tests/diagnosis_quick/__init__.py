"""Tests of diagnosis that take no time: those of `tests/diagnosis` are left to the slow lane as a whole."""
