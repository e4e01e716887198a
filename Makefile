# make demo: sets everything up and runs the main job on samples/
# make check: sets everything up and runs the quick lane: lint, imports, types and the tests that are fast
# make test: sets everything up and passes all tests; TEST_SECONDS=1500 leaves out slow tests that have not begun by then
# make wheel-check: builds the wheel, installs it alone into an environment of its own, and runs the demo there
# make oldest: core tests with the oldest run-time dependencies that pyproject.toml allows
# make newest: core tests on the newest Python that is installed
# make other-user: what root may not skip, as another user
# make site: the pages as a site in site/; a broken link fails
# make mutants: how many small slips in the core its tests notice; PACKAGE=mechanism SAMPLE=50
# make lock: holds the development tools to the versions that are in the environment now
# PYTHON=python3.12 chooses another interpreter, VENV=folder another place

PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys, venv; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null && echo $$p && break; done)
VENV ?= .venv
BIN = $(VENV)/bin

demo: $(VENV)/.demo
	$(BIN)/xneck demo --out out

# development tools have exact versions; run-time dependencies are free within their bounds
DEV = --constraint .ci/dev-tools.txt --editable '.[dev]'
PYTEST = OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/pytest

# types take one core for as long as the fast tests take the other
check: $(VENV)/.test
	$(MAKE) --no-print-directory --jobs 2 --output-sync=target VENV=$(VENV) lint types fast-tests

test: $(VENV)/.test
	$(MAKE) --no-print-directory VENV=$(VENV) lint
	$(MAKE) --no-print-directory --jobs 2 VENV=$(VENV) types all-tests

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

types: $(VENV)/.test
	$(BIN)/pyright --pythonpath $(BIN)/python

all-tests: $(VENV)/.test
	$(PYTEST) -n auto --maxprocesses 4 --dist loadfile --no-loadscope-reorder $(if $(TEST_SECONDS),--seconds $(TEST_SECONDS))

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

CORE = tests/xneck_foundation tests/mechanism tests/discovery tests/identification tests/state_estimation tests/synchronisation
SUBSET = $(CORE) tests/calibration tests/vision tests/xneck/recording -m "not slow" -q
# what another interpreter may change shows in the core; in vision and calibration other people's libraries do the work
NEWEST_SUBSET = $(CORE) -m "not slow" -q

# what these tests need of the development tools: some others ask for newer dependencies than the oldest that are allowed
TOOLS = --editable . pytest pytest-timeout pytest-xdist hypothesis playwright mujoco mcap-ros2-support pyapriltags jsonschema rosbags pyarrow

oldest: | $(BIN)/python
	$(PYTHON) -m venv --clear $(VENV)/oldest
	$(BIN)/python .ci/lower_bounds.py > $(VENV)/oldest/oldest.txt
	grep -v mcap-ros2-support .ci/dev-tools.txt >> $(VENV)/oldest/oldest.txt
	$(VENV)/oldest/bin/python -m pip install --quiet --constraint $(VENV)/oldest/oldest.txt $(TOOLS)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(VENV)/oldest/bin/pytest -n 2 --dist loadfile $(SUBSET)

# also those of pyenv, which has only the chosen one on the path
NEWEST = $(shell for p in $(foreach v,3.13 3.12,python$(v) $(lastword $(wildcard $(HOME)/.pyenv/versions/$(v).*/bin/python))); do $$p -c 'import venv' 2>/dev/null && echo $$p && break; done)

newest:
	@test -n "$(NEWEST)" || { echo "NOT RUN: neither Python 3.13 nor 3.12 is installed"; exit 0; }; \
	test -z "$(NEWEST)" || { set -ex; $(NEWEST) -m venv --clear $(VENV)/newest; \
	$(VENV)/newest/bin/python -m pip install --quiet --constraint .ci/dev-tools.txt $(TOOLS); \
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(VENV)/newest/bin/pytest -n 2 --dist loadfile $(NEWEST_SUBSET); }

# `nobody` is given a copy: a checkout may lie where it may not go
other-user: $(VENV)/.test
	.ci/other-user $(BIN)/python

site: $(VENV)/.test
	$(BIN)/python .ci/site.py site

mutants: $(VENV)/.test
	$(BIN)/python -m pip install --quiet --constraint .ci/dev-tools.txt '.[mutation]'
	$(BIN)/python -m benchmarks.mutants $(if $(PACKAGE),--package $(PACKAGE)) $(if $(SAMPLE),--sample $(SAMPLE))

lock: $(VENV)/.test
	$(BIN)/python .ci/lock.py > $(VENV)/dev-tools.txt && mv $(VENV)/dev-tools.txt .ci/dev-tools.txt

$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "no Python 3.11, 3.12 or 3.13 found; name one: make PYTHON=/path/to/python3.12 ..."; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/.test: pyproject.toml .ci/dev-tools.txt | $(BIN)/python
	$(BIN)/python -m pip install --quiet $(DEV)
	@touch $@ $(VENV)/.demo

.PHONY: demo check test lint types all-tests fast-tests bench samples wheel-check oldest newest other-user site mutants lock
