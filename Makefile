# Two commands do everything: `make demo` runs the main job, `make test` passes the tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: demo test test-all fuzz docs lint format bless clean help

help:
	@echo "make demo      track and score a synthetic crossing (no data needed): out/demo"
	@echo "make test      run the tests (those that need KITTI run when MOT_SIM_KITTI_ROOT is set)"
	@echo "make test-all  the slow ones too (kills, clusters, training, fresh environments), all"
	@echo "               with the shapes of all arrays checked"
	@echo "make fuzz      every reader with 100,000 bad files (INPUTS=...); hours"
	@echo "make docs      the documentation as a site: out/site/index.html"
	@echo "make lint      ruff (lint and format) and mypy"
	@echo "make format    let ruff mend what it can"
	@echo "make clean     remove the environment and everything that was made"

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "Python 3.11 or newer is needed; name it: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@

demo: $(STAMP)
	$(BIN)/mot-sim demo --out out/demo --overwrite

PYTEST := $(BIN)/python -m pytest -n auto --dist loadfile
UNCHECKED := -o addopts=--strict-markers

# Checking the shape of every array doubles the time: here for the tracker and the contracts,
# everywhere in test-all.
test: $(STAMP)
	$(PYTEST) -m "not slow" $(UNCHECKED) --cov --cov-report=term
	$(PYTEST) -m "not slow and not kitti" tests/tracker tests/contracts

test-all: $(STAMP)
	$(PYTEST)

INPUTS ?= 100000
# As users run it, without type checks; make test has 1,000 inputs each.
fuzz: $(STAMP)
	MOT_SIM_FUZZ=$(INPUTS) $(BIN)/python -m pytest tests/fuzz $(UNCHECKED)

DOCS_STAMP := $(VENV)/.docs-installed
$(DOCS_STAMP): $(STAMP)
	$(BIN)/python -m pip install --quiet --editable '.[dev,docs]'
	@touch $@

docs: $(DOCS_STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) out build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage
