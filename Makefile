# Every command a developer or CI needs. `make` alone lists them.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
AGENT ?=

# The tests of the page run alone, one after the other: a browser wants the processors to itself.
# pytest gives 5 where PYTEST_ARGS leave none of one kind.
PYTEST = $(BIN)/python -m pytest
TESTS = { $(PYTEST) -m "not browser" -n logical --maxprocesses 4 --dist worksteal \
	$(PYTEST_ARGS) || [ $$? = 5 ]; } && { $(PYTEST) -m browser $(PYTEST_ARGS) || [ $$? = 5 ]; }

.DEFAULT_GOAL := help
.PHONY: help install app test check format lint types schemas pictures browser clean

help: ## List these commands.
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | \
		while IFS="$$(printf '\t')" read -r name text; do printf '  make %-9s %s\n' "$$name" "$$text"; done

install: $(VENV)/.dev ## Make .venv with the app and the developers' tools; needs no root.

app: $(VENV)/.app ## Install what is missing, then open the dashboard (AGENT=file for another agent).
	@$(BIN)/python app.py $(AGENT)

test: $(VENV)/.test browser ## Install what is missing, then run every test.
	@$(TESTS)

check: $(VENV)/.test browser ## Check format, lint and types, then run every test.
	@$(MAKE) --no-print-directory lint types
	@$(TESTS)

lint: $(VENV)/.dev ## Check format and lint.
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .

types: $(VENV)/.test ## Check types.
	@$(BIN)/pyright

format: $(VENV)/.dev ## Format the code and mend what the linter can.
	@$(BIN)/ruff format .
	@$(BIN)/ruff check --fix .

schemas: $(VENV)/.app ## Make the trained agents that ship with the app anew.
	$(call schema,CartPole-v1,20000,0,--set refreshes=8 --set attention_width=5)
	$(call schema,Pendulum-v1,10000,0,--set refreshes=8)
	$(call schema,Acrobot-v1,19500,0,--set refreshes=8 --set levels=3)
	$(call schema,MountainCar-v0,20000,0,--set refreshes=8)

# Environment, steps, seed, settings: train one agent and record two episodes into its file.
define schema
	$(BIN)/ao2viz train $(1) --steps $(2) --seed $(3) $(4) --out saved_schemas/$(1).ao2 --overwrite
	$(BIN)/ao2viz record saved_schemas/$(1).ao2 --episodes 2
endef

pictures: $(VENV)/.test browser ## Take the pictures of the guide anew, in both themes (NAMES=… for some).
	@$(BIN)/python -m tools.pictures $(NAMES)

clean: ## Remove .venv and everything else that was made here.
	rm -rf $(VENV) dist build .pytest_cache .ruff_cache .hypothesis test-results
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Three stamps, so that nothing is installed twice and `make app` fetches no developers' tools.
$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "ao2viz needs Python 3.11 or newer, but $(PYTHON) is" \
			"$$($(PYTHON) --version 2>&1 || echo missing)." \
			"Name another: make PYTHON=python3.12 …" >&2; exit 1; }
	@echo "Making $(VENV) …"
	@$(PYTHON) -m venv $(VENV)

$(VENV)/.app: pyproject.toml | $(BIN)/python
	@echo "Installing ao2viz into $(VENV) …"
	@$(PIP) --editable .
	@touch $@

$(VENV)/.dev: pyproject.toml $(VENV)/.app
	@echo "Installing the developers' tools …"
	@$(PIP) --editable '.[dev]'
	@touch $@

$(VENV)/.test: pyproject.toml tests/constraints.txt $(VENV)/.dev
	@echo "Installing what only the tests need (PyTorch is a large download) …"
	@$(PIP) --editable '.[test]' --constraint tests/constraints.txt
	@touch $@

# The browser tests look for the same names. Without any, they skip, or fail where CI is set.
browser:
	@for name in chromium chromium-browser google-chrome google-chrome-stable; do \
		if command -v $$name >/dev/null; then exit 0; fi; done; \
	if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; then \
		echo "Installing Chromium for the browser tests …"; \
		export DEBIAN_FRONTEND=noninteractive; \
		apt-get update -qq && apt-get install -qq -y --no-install-recommends chromium >/dev/null; \
	else \
		echo "No Chromium or Chrome found: the browser tests will be skipped." \
			"Install one (Debian: sudo apt-get install chromium) to run them." >&2; \
	fi
