# Everything runs in .venv, which the first target to need it makes; `make` alone lists the targets.
PYTHON ?= python3
SCENE ?= bell
VENV := .venv
BIN := $(VENV)/bin

# The work is serial: more threads than one only get in each other's way.
export OMP_NUM_THREADS ?= 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PYRIGHT_PYTHON_IGNORE_WARNINGS := 1

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow lint format types bench clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(VENV)/.installed  ## train an agent on the ball, judge it, draw it (SCENE=bell or rolling)
	$(BIN)/python -m agents train configs/ball_on_bar/ppo.yaml --scene $(SCENE)

test: $(VENV)/.installed-dev  ## run the test suite, in two processes
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-slow: $(VENV)/.installed-dev  ## run the tests that take minutes
	$(BIN)/python -m pytest -m slow

lint: $(VENV)/.installed-dev  ## check style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: $(VENV)/.installed-dev  ## fix style and formatting
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: $(VENV)/.installed-dev  ## check types
	$(BIN)/pyright --pythonpath $(BIN)/python

bench: $(VENV)/.installed-dev  ## measure error, speed, stability and the cost of features, in about nine minutes
	$(BIN)/vr-envs bench accuracy
	$(BIN)/vr-envs bench speed
	$(BIN)/vr-envs bench stress
	$(BIN)/vr-envs bench features

clean:  ## remove the environment and every cache; runs/ stays
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .ruff_cache .hypothesis
	find vr_envs agents tests -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamps make a second run start at once, and a changed pyproject.toml install again.
$(VENV)/.installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "Python 3.11 or later is needed; give it as make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[render,agents,tune]'
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[render,agents,tune,dev]'
	@touch $@
