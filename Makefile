# make pilot   the paper's whole study, simulated      make pilot ARGS="--participants 4 --seed 1"
# make test    lint, types, import layers, tests
# make setup   only the environment, in .venv
PYTHON ?= python3
BIN = .venv/bin
ARGS ?=

.PHONY: setup pilot test lint requirements
setup:
	@$(PYTHON) tools/setup.py

pilot: setup
	@$(PYTHON) tools/system_packages.py --optional
	@$(BIN)/slipscale pilot $(ARGS)

test: setup
	@$(PYTHON) tools/system_packages.py
	$(MAKE) --no-print-directory lint
	$(BIN)/python -m pytest -n 2 --dist loadfile $(ARGS)

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy

# Pins for every platform and Python; no index addresses in the file.
requirements:
	uv pip compile --universal --python-version 3.11 --no-emit-index-url --no-annotate --no-header --quiet pyproject.toml --group dev -o requirements.txt
