# Every target sets up what it needs in .venv, once: a second call does not install again.
# The first that runs; 3.11 has a wheel of PyBullet.
FITS := import sys; assert (3, 11) <= sys.version_info < (3, 14); print(sys.executable)
PYTHON ?= $(shell for python in python3.11 python3.12 python3.13 python3 python; do \
	$$python -c '$(FITS)' 2>/dev/null && break; done)
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
READY := $(VENV)/.ready
CODE := scenarios reference engines reports
# Bytecode is kept, whatever the environment says: else every process of a target compiles what it imports, for 2 s.
export PYTHONDONTWRITEBYTECODE =
# Matrices are small: a second thread of linear algebra only spins, and doubles the CPU time of fits.
export OPENBLAS_NUM_THREADS ?= 1
# The distributions on the first page, a scene of each kind of motion scattered: defaults, and what is recommended
# instead, at stock timesteps.
SPREAD := football-spiral book-middle-axis fast-top lopsided-body motor-driven-top --ensemble 50 \
	--engine mujoco --engine pybullet \
	--method default --method RK4 --method multibody

.PHONY: docs results report engines engines-2026 test quick pythons bench kills survey thresholds random
.PHONY: random-single suite power known-issues methods lines recorded-motions gradients sensitivities
.PHONY: lint types contract check schema format-page clean

# The page is there to look at after the free and the heavy tops, on short ladders and without the
# costs of steps, and once more when costs, longer ladders, all other scenes and the distribution are
# done.
# Exit code 1 says that something disagrees: the report tells what.
report: $(INSTALLED)
	$(BIN)/spincheck run --quick scenarios/library/free scenarios/library/heavy || [ $$? -eq 1 ]
	$(BIN)/spincheck report || [ $$? -eq 1 ]
	$(BIN)/spincheck run || [ $$? -eq 1 ]
	$(BIN)/spincheck run $(SPREAD) || [ $$? -eq 1 ]
	$(BIN)/spincheck report || [ $$? -eq 1 ]

# Every optional engine: Python packages into .venv, npm packages into the user's cache.
engines: $(INSTALLED)
	$(BIN)/pip install --quiet --editable '.[dartpy,drake,exudyn,mjx,pin,pybox3d,rapier3d]'
	$(BIN)/python -m spincheck.engines.adapters.node || [ $$? -eq 3 ]

# Engines of 500 MB and more that compile their kernels for minutes, once: apart, so that `make engines` stays fast.
engines-2026: $(INSTALLED)
	@echo "Installing Brax, Genesis, MuJoCo Warp and Newton, 4.3 GB; more where torch brings CUDA."
	$(BIN)/pip install --quiet --editable '.[brax,genesis,mujoco-warp,newton]'

test: $(READY)
	$(BIN)/pytest -n auto --dist loadfile --no-loadscope-reorder tests scenarios/library

# Nothing that starts a process, and none of the library's runs: to be called after every change.
quick: $(READY)
	$(BIN)/pytest -n auto --dist loadfile -m 'not processes and not slow' tests

# The quick tests on every Python there is of 3.11 to 3.13.
pythons: $(READY)
	$(BIN)/nox

# The site, build/docs/index.html: every page, with the examples' output, and no warning.
docs: $(INSTALLED)
	$(BIN)/pip install --quiet --editable '.[docs]'
	$(BIN)/python -m sphinx --fail-on-warning --keep-going -q -j 2 docs build/docs

# Speed, with nothing else running.
bench: $(READY)
	for script in tests/bench/*.py; do $(BIN)/python $$script || exit 1; done

# Runs killed with -9 at random moments must go on to the same results.
kills: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/cli/kills.py

# The smallest planted fault that is detected, by kind, method class and scene; written to docs/measured/thresholds.md.
thresholds: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_thresholds.py

# Derivatives that engines give of their steps, right or not, how far off, and their cost; docs/measured/gradients.md.
gradients: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_gradients.py

# The exact derivatives beside differences in forty digits, over the library; docs/explanation/sensitivities.md.
sensitivities: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reference/measure_sensitivity.py

# Faults planted at random, by somebody who did not write the checks; docs/measured/power.md.
power: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_power.py

# Every engine and method: verdicts, error, floor, batch, size, cost of steps; docs/measured/methods.md.
methods: $(READY)
	$(BIN)/python tests/reports/harness/measure_methods.py

# Dated pages of what each engine and version does on the library: docs/results.
results: $(INSTALLED)
	$(BIN)/python docs/results/publish.py

# Faultless methods on a thousand random scenes: what is judged wrongly, counted.
random: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_random.py

# The same of the engines of single precision that are installed.
random-single: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_random.py 100 0 single

# The tests for engines' own continuous integration, on every engine there is.
suite: $(READY)
	$(BIN)/pytest --pyargs spincheck.suite --spincheck-engine all \
		--spincheck-xfails tests/reports/interface/suite/known_failures.toml

# What became of public issues on the rotation of single bodies, in the engines at hand; docs/measured/known-issues.md.
known-issues: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/measure_known_issues.py

# What judge says of motions with the faults of public reports, and of honest ones; docs/measured/recorded-motions.md.
recorded-motions: $(READY)
	PYTHONPATH=tests/support $(BIN)/python tests/reports/harness/recorded/measure_explanations.py

# What engines hold of the robots of public packages (200 MB of them): docs/measured/public-models.md.
survey: $(READY)
	$(BIN)/pip install --quiet --editable '.[models]'
	$(BIN)/python tests/reports/users_models/survey.py

check: lint types contract

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

contract: $(READY)
	PYTHONPATH=.types $(BIN)/lint-imports

# Lines of code by folder, without docstrings, comments and blank lines.
lines: $(READY)
	$(BIN)/python tests/lines_of_code.py

schema: $(READY)
	$(BIN)/python -m spincheck.scenarios.schema

format-page: $(READY)
	$(BIN)/python -m spincheck.scenarios.format_page > docs/reference/scene-format.md

# Without bytecode of what may never be imported: half the time that pip takes.
$(INSTALLED): pyproject.toml
	$(if $(PYTHON),,$(error no Python from 3.11 to 3.13 was found; PYTHON=… names one))
	@echo "Setting up $(VENV) with $(PYTHON)."
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --no-compile --editable .
	$(BIN)/python -m spincheck.reports.harness.executors.compiling
	touch $@

# What developing needs besides.
$(READY): $(INSTALLED)
	$(BIN)/pip install --quiet --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) build spincheck-report spincheck.sqlite spincheck.sqlite-shm spincheck.sqlite-wal
	find $(CODE) tests -name __pycache__ -prune -exec rm -rf {} +
