# make demo: sets everything up and runs the main job on samples/
# make check: sets everything up and runs the quick lane: lint, imports, types and the tests that are fast
# make test: sets everything up and passes all tests
# make wheel-check: builds the wheel, installs it alone into an environment of its own, and runs the demo there
# PYTHON=python3.12 chooses another interpreter, VENV=folder another place

PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys, venv; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null && echo $$p && break; done)
VENV ?= .venv
BIN = $(VENV)/bin

demo: $(VENV)/.demo
	$(BIN)/xneck demo --out out

PYTEST = OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/pytest

# types take one core for as long as the fast tests take the other
check: $(VENV)/.test
	$(MAKE) --no-print-directory --jobs 2 --output-sync=target VENV=$(VENV) lint types fast-tests

test: $(VENV)/.test
	$(MAKE) --no-print-directory VENV=$(VENV) lint types
	$(PYTEST) -n auto --maxprocesses 4 --dist loadfile

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: $(VENV)/.test
	$(BIN)/pyright --pythonpath $(BIN)/python

fast-tests: $(VENV)/.test
	$(PYTEST) -m "not slow" -q

bench: $(VENV)/.test
	$(BIN)/python -m benchmarks

samples: $(VENV)/.test
	$(BIN)/python -m samples.generator --seed 1

# the wheel alone, in an environment of its own, away from the checkout
wheel-check: | $(BIN)/python
	rm -rf $(VENV)/wheel && $(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir $(VENV)/wheel .
	$(PYTHON) -m venv --clear $(VENV)/wheel/env
	$(VENV)/wheel/env/bin/python -m pip install --quiet $(VENV)/wheel/*.whl
	cd $(VENV)/wheel && env/bin/xneck --help && env/bin/xneck demo --out out

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "no Python 3.11, 3.12 or 3.13 found; name one: make PYTHON=/path/to/python3.12 ..."; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/.test: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@ $(VENV)/.demo

.PHONY: demo check test lint types fast-tests bench samples wheel-check
