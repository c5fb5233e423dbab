# Two commands do everything: `make demo` runs the main job, `make test` passes the tests.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: demo test test-all test-gl test-rl test-browser test-lowest environments fuzz docs lint format clean help

help:
	@echo "make demo      track and score a synthetic crossing (no data needed): out/demo"
	@echo "make test      run the tests (those that need KITTI run when MOT_SIM_KITTI_ROOT is set)"
	@echo "make test-all  the slow ones too (kills, clusters, training, fresh environments), all"
	@echo "               with the shapes of all arrays checked"
	@echo "make test-gl   those that need OpenGL (EGL), in an environment with the extra gl"
	@echo "make test-rl   environments under Stable-Baselines3, in an environment with rl and video"
	@echo "make test-browser  those that need a Chromium; the site is built before"
	@echo "make test-lowest   the core on the lowest versions that pyproject.toml allows"
	@echo "make fuzz      every reader with 100,000 bad files (INPUTS=...); hours, resumable"
	@echo "make docs      the documentation as a site: out/site/index.html"
	@echo "make lint      ruff (lint and format) and mypy"
	@echo "make format    let ruff mend what it can"
	@echo "make clean     remove the environment and everything that was made"

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "Python 3.11 or newer is needed; name it: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	$(BIN)/mot-sim doctor --warm
	@touch $@

demo: $(STAMP)
	$(BIN)/mot-sim demo --out out/demo --overwrite

PYTEST := $(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder --durations=25
UNCHECKED := -o addopts=--strict-markers

# Checking the shape of every array doubles the time: here for the tracker and the contracts, with
# few examples of each property, since the first line tries many, and without the environments, which
# are built of the simulator; everywhere in test-all.
test: $(STAMP)
	$(PYTEST) -m "not slow" $(UNCHECKED) --cov --cov-report=term
	$(PYTEST) -m "not slow and not kitti" --hypothesis-profile few tests/tracker tests/contracts \
	    --ignore tests/contracts/test_environments.py \
	    --ignore tests/contracts/test_environment_wrappers.py

test-all: $(STAMP)
	$(PYTEST)

# An environment of its own: pyrender pins an old PyOpenGL.
GL_STAMP := .venv-gl/.installed
$(GL_STAMP): pyproject.toml
	$(PYTHON) -m venv .venv-gl
	.venv-gl/bin/python -m pip install --quiet --editable '.[gl]' 'pytest>=8,<10' 'hypothesis>=6.100,<7' 'shapely>=2.1,<3'
	@touch $@

test-gl: $(GL_STAMP)
	.venv-gl/bin/python -m pytest -m gl --must-run gl $(UNCHECKED) tests/mot_sim/simulation

# An environment of its own: Stable-Baselines3 brings torch.
RL_STAMP := .venv-rl/.installed
$(RL_STAMP): pyproject.toml
	$(PYTHON) -m venv .venv-rl
	.venv-rl/bin/python -m pip install --quiet --editable '.[rl,video]' 'pytest>=8,<10' 'hypothesis>=6.100,<7'
	@touch $@

test-rl: $(RL_STAMP)
	.venv-rl/bin/python -m pytest -m slow --must-run slow $(UNCHECKED) \
	    tests/contracts/test_environment_wrappers.py tests/test_examples.py

test-browser: docs
	$(BIN)/python -m pytest -m browser --must-run browser $(UNCHECKED) tests/mot_sim/report tests/test_site.py

LOWEST_STAMP := .venv-lowest/.installed
$(LOWEST_STAMP): pyproject.toml tests/lowest_versions.py
	$(PYTHON) -m venv .venv-lowest
	$(PYTHON) tests/lowest_versions.py > .venv-lowest/lowest.txt
	.venv-lowest/bin/python -m pip install --quiet --constraint .venv-lowest/lowest.txt --editable . 'pytest>=8,<10' 'hypothesis>=6.100,<7'
	@touch $@

# Deprecations of old releases are not ours to mend. The first Gymnasium has no modes of autoreset,
# which the contract of wrappers compares.
test-lowest: $(LOWEST_STAMP)
	.venv-lowest/bin/python -m pytest -m "not slow and not kitti and not gl and not browser" $(UNCHECKED) \
	    -W default tests/tracker tests/contracts tests/mot_sim/metrics tests/mot_sim/datasets tests/mot_sim/files \
	    --ignore tests/contracts/test_environment_wrappers.py

# Both at once, beforehand; what is there already is left as it is.
environments: $(GL_STAMP) $(LOWEST_STAMP)

INPUTS ?= 100000
# As users run it, without type checks; make test has 1,000 inputs each. An interrupted run goes on
# where it was; remove out/fuzz to begin anew.
fuzz: $(STAMP)
	MOT_SIM_FUZZ=$(INPUTS) MOT_SIM_FUZZ_FOLDER=out/fuzz $(BIN)/python -m pytest tests/fuzz $(UNCHECKED)

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
	rm -rf $(VENV) .venv-gl .venv-rl .venv-lowest out build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage
