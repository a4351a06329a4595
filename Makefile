# make pilot   the paper's whole study, simulated      make pilot ARGS="--participants 4 --seed 1"
# make test    lint, types, import layers, tests
# make docs    the documentation site, in build/site: open build/site/index.html
# make setup   only the environment, in .venv
PYTHON ?= python3
BIN = .venv/bin
ARGS ?=

.PHONY: setup pilot test lint docs requirements
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

# Warnings are errors. The tests build the site too.
docs: setup
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict $(ARGS)

# Pins for every platform and Python; no index addresses in the file.
requirements:
	uv pip compile --universal --python-version 3.11 --no-emit-index-url --no-annotate --no-header --quiet pyproject.toml --group dev -o requirements.txt
