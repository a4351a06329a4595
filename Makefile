# make pilot   the paper's whole study, simulated      make pilot ARGS="--participants 4 --seed 1"
# make test    all tests, in random order; in an earlier run's order: make test ARGS="--randomly-seed=N"
# make lint    lint, types, import layers, how we write
# make platforms  types on Windows and macOS
# make docs    the documentation site, in build/site: open build/site/index.html
# make coverage  how much of some rooms their tests reach; all: make coverage COVERED="analysis experiments hardware stimuli"
# make torture  the campaign of kills and disk faults (minutes)
# make sbom    what the environment holds: versions and licences, for an audit
# make audit   known vulnerabilities of the pinned versions (network)
# make fuzz     10,000 changed files of every kind that we read: make fuzz FILES=100000
# make benchmarks  each quick benchmark's ratio beside the recorded one
# make windows  signals and lost displays in real windows: make windows ARGS="--signals 5000"
# make soak     an eight-hour day in one process, in short: make soak ARGS="--hours 8"
# make disk     every call that writes to a data set fails once, or from then on
# make unattended  sessions that are killed, stopped, out of memory: make unattended ARGS="--times 50"
# make wheel   the wheel in a new environment: pilot, session in a window, analysis, export (network)
# make workflows  the workflow files by their schema, and the archives' metadata (network)
# make lowest  the tests with the lowest allowed version of each package (network)
# make reliability  every line of docs/validation/index.md
# make setup   the environment of a laboratory's computer, in .venv: sessions and their analysis
PYTHON ?= python3
BIN = .venv/bin
ARGS ?=
WORKERS ?= logical

.PHONY: set-pilot set-session set-test setup pilot test lint platforms docs pictures torture windows fuzz soak unattended disk reliability benchmarks coverage requirements sbom audit wheel workflows lowest lowest-requirements
# Each set of packages contains the one before: pilot, session, test.
set-pilot set-session set-test: set-%:
	@$(PYTHON) tools/setup.py $*

setup: set-session
	@$(PYTHON) tools/system_packages.py --optional

pilot: set-pilot
	@$(BIN)/slipscale pilot $(ARGS)

test:
	@# Packages of system and Python are installed at the same time. Without bytecode, every process
	@# that a test starts would compile all modules again; collecting the tests once compiles them,
	@# while the system's packages arrive. Errors of that collection are those of missing packages.
	@unset PYTHONDONTWRITEBYTECODE; \
	$(PYTHON) tools/system_packages.py & packages=$$!; \
	$(PYTHON) tools/setup.py test || exit; \
	[ -d .pytest_cache ] || $(BIN)/python -m pytest --collect-only -qq >/dev/null 2>&1; \
	wait $$packages || exit; \
	$(BIN)/python -m tests.support.parts -n $(WORKERS) --durations 30 --durations-min 1 $(ARGS)

lint: set-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports
	$(BIN)/mypy
	$(BIN)/python -m tools.prose
	@mkdir -p build
	@$(BIN)/pip-licenses --output-file build/licences.md

# Types as Windows and macOS have them; their systems lack modules that Linux has.
platforms: set-test
	$(BIN)/mypy --platform win32 --no-warn-unreachable --cache-dir .mypy_cache/win32 src/slipscale
	$(BIN)/mypy --platform darwin --no-warn-unreachable --cache-dir .mypy_cache/darwin src/slipscale

# Tracing makes Python 3.11 some 70 % slower: CI prints the figure of rooms whose tests are quick.
COVERED = stimuli experiments/protocols experiments/study experiments/dataset experiments/journal
coverage: set-test
	$(BIN)/python -m pytest -q -n 2 --dist loadfile $(addprefix tests/,$(COVERED)) $(addprefix --cov=,$(COVERED)) --cov-report=term:skip-covered $(ARGS)

# Warnings are errors. The tests build the site too.
docs: set-test
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict $(ARGS)

# The README's picture of a pilot, and the pictures of the tutorial pages; needs a display.
pictures: set-test
	rm -rf build/pilot && $(BIN)/slipscale pilot --out build/pilot
	cp build/pilot/derivatives/slipscale/fig15.svg docs/images/
	$(BIN)/python tools/tutorial_pictures.py $(ARGS)

# Kills and disk faults; docs/validation/index.md. 10,000 cases: make torture ARGS="--places 45 --write"
torture: set-test
	$(BIN)/python -m tools.campaigns torture $(ARGS)

# Sessions in windows that are ended by signals, and by their X server; docs/validation/index.md.
windows: set-test
	$(BIN)/python -m tools.campaigns windows $(ARGS)

# Each of FILES changed files per kind must be used or rejected; a failure is shrunk and kept.
FILES = 10000
fuzz: set-test
	FUZZED_FILES=$(FILES) $(BIN)/python -m pytest -n $(WORKERS) tests/fuzzing $(ARGS)

# Sessions over the emulated board, one after another in one process.
soak: set-test
	$(BIN)/python -m tools.campaigns soak $(ARGS)

unattended: set-test
	$(BIN)/python -m tools.campaigns unattended $(ARGS)

disk: set-test
	$(BIN)/python -m tools.campaigns disk $(ARGS)

# Exit status 1 if a ratio is more than 20 % worse twice in a row; new figures: make benchmarks ARGS=--write
benchmarks: set-test
	$(BIN)/python -m benchmarks.quick $(ARGS)

# Every line of docs/validation/index.md, by the command that stands there.
reliability: set-test
	$(BIN)/python -m tools.campaigns reliability $(ARGS)

# Pins with hashes for every platform and Python, a file per set; no index addresses in them. Versions
# are those of the test set; what is left out is listed under [tool.uv] in pyproject.toml.
COMPILE = uv pip compile --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-annotate --no-header --quiet pyproject.toml
requirements:
	$(COMPILE) --extra all --group dev -o requirements/test.txt
	$(COMPILE) --extra all -c requirements/test.txt -o requirements/session.txt
	$(COMPILE) --extra analysis -c requirements/test.txt -o requirements/pilot.txt

# The lowest versions that pyproject.toml allows, on Linux with Python 3.11, and the tests in an
# environment of them. Old packages warn of what newer ones deprecate.
LOWEST = uv pip compile --python-version 3.11 --python-platform x86_64-manylinux_2_28 --only-binary :all: --no-binary esprima --no-emit-index-url --no-annotate --no-header --quiet pyproject.toml
QUICK = tests/stimuli tests/faults tests/hardware tests/analysis tests/experiments/dataset tests/experiments/protocols tests/experiments/study
OLD = -W ignore::DeprecationWarning -W ignore::FutureWarning -W ignore::PendingDeprecationWarning
lowest-requirements:
	@mkdir -p build
	$(LOWEST) --extra all --extra cluster --resolution lowest-direct -o build/lowest.txt
	$(LOWEST) --extra all --extra cluster --group tests -c build/lowest.txt -o requirements/lowest.txt
lowest:
	uv venv --quiet --clear --python 3.11 build/lowest
	uv pip install --quiet --python build/lowest --no-deps -r requirements/lowest.txt -e .
	build/lowest/bin/python -m pytest -n $(WORKERS) -m "not window" -p no:cacheprovider $(OLD) $(QUICK) $(ARGS)

# What the environment holds, versions and licences, in CycloneDX's form: build/sbom.json.
sbom: set-test
	@mkdir -p build
	$(BIN)/cyclonedx-py environment --pyproject pyproject.toml --output-reproducible --output-file build/sbom.json .venv

# Known vulnerabilities of the pinned versions; asks a public data base, so it needs a network.
audit:
	uvx pip-audit --requirement requirements/test.txt --require-hashes --disable-pip

# The wheel as a user has it, without this repository.
wheel: set-test
	$(BIN)/python -m tools.try_wheel

workflows: set-test
	uvx check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	rm -rf build/dist && $(BIN)/python -m hatchling build -d build/dist
	uvx twine check --strict build/dist/*
