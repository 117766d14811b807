# Needs nothing but Python (>= 3.11, with venv) and make. `make demo` shows, `make test` proves.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: demo live-demo commander-demo test check unit coverage fast docs wheel release-check clean

demo: $(VENV)/.installed
	$(BIN)/otolith run step-sine-0.5 --cueing hybrid-all --out demo --force
	@echo "open demo/report.html"

live-demo: $(VENV)/.installed-live
	$(BIN)/otolith live demo --seconds 20

commander-demo: $(VENV)/.installed-commander
	$(BIN)/otolith commander --browser

# Side by side: the checks need one processor for minutes, and so do a few tests at the end.
test: $(VENV)/.installed-dev
	$(MAKE) --jobs 2 check unit

check: $(VENV)/.installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# In the order of files: by default those with few tests come last, and among these are the longest tests.
unit: $(VENV)/.installed-dev
	$(BIN)/pytest --numprocesses auto --dist loadfile --no-loadscope-reorder

# Measuring it makes tests that are mostly Python more than twice as slow, so it is a command of its own.
coverage: $(VENV)/.installed-dev
	$(BIN)/pytest --numprocesses auto --dist loadfile --no-loadscope-reorder --cov --cov-fail-under=95

# One's daily loop: whatever calls a compiled kernel is skipped; drawing and the many logs of others, which
# take most of the rest, are left out. For one folder: make fast TESTS=tests/report
fast: TESTS ?= tests --ignore=tests/report --ignore=tests/recordings/checks
fast: $(VENV)/.installed-dev
	$(BIN)/pytest --fast -q $(TESTS)

# The site of the docs, in `site/`; a warning is an error. Notebooks run anew when the source has changed.
docs: $(VENV)/.installed-docs
	$(BIN)/sphinx-build -W --keep-going -E -q -d .docs_cache/doctrees -c docs . site
	@echo "open site/index.html"

# A wheel with machine code, for this Python and system: its first run need not compile.
wheel: $(VENV)/.installed
	$(BIN)/python tools/ship_kernels.py
	$(BIN)/python -m pip wheel --disable-pip-version-check --no-deps --wheel-dir dist .

# All that is asked of a release, without publishing it: two equal builds, sizes, licences, versions.
release-check: $(VENV)/.installed-release
	$(BIN)/python tools/release_check.py

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(v < (3, 11) and f"Otolith needs Python 3.11 or newer, this is {v[0]}.{v[1]}: make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.installed: pyproject.toml thesis/pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable . --editable thesis
	@touch $@

$(VENV)/.installed-live: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[live]'
	@touch $@

$(VENV)/.installed-commander: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[commander]'
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	@touch $@

$(VENV)/.installed-release: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[release]'
	@touch $@

$(VENV)/.installed-dev: pyproject.toml thesis/pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]' --editable thesis
	@touch $@ $(VENV)/.installed

clean:
	rm -rf $(VENV) demo out site .docs_cache jupyter_execute docs/api .mypy_cache .ruff_cache .pytest_cache .hypothesis .coverage
