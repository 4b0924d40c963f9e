# `make demo` and `make test` do all their own set-up: a virtual environment in .venv, from Python
# >= 3.11 and make alone. The package under test is the built wheel, never the source folders.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SOURCES := $(shell find models systems diagrams analysis -type f -not -path '*/__pycache__/*' 2>/dev/null)
PYTEST := cd tests && ../$(BIN)/python -m pytest -c ../pyproject.toml --rootdir .. .

.PHONY: demo test lint types studies docs clean
demo: $(VENV)/installed
	$(BIN)/gapscope demo --out out/demo

test: $(VENV)/installed lint types
	$(PYTEST) -m "not slow" -n 2

studies: $(VENV)/installed
	$(PYTEST) -m slow

# The public API from its docstrings, a static site in out/docs/.
docs: $(VENV)/installed
	$(BIN)/pdoc --docformat numpy --math --template-directory .ci/docs --output-directory out/docs \
		gapscope.models gapscope.systems gapscope.diagrams gapscope.analysis
	$(BIN)/python -c 'from pathlib import Path; print(Path("out/docs/index.html").resolve())'

lint: $(VENV)/tools
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/installed
	cd $(VENV) && bin/mypy --config-file ../pyproject.toml

$(VENV)/python:
	$(PYTHON) -c 'import sys; sys.exit("gapscope needs Python >= 3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	touch $@

$(VENV)/tools: $(VENV)/python pyproject.toml
	$(BIN)/python -m pip install --quiet --group dev
	touch $@

# build/ is removed first: setuptools would ship stale files from it.
$(VENV)/installed: $(VENV)/tools pyproject.toml README.md $(SOURCES)
	rm -rf build dist
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	$(BIN)/python -m pip install --quiet dist/*.whl
	$(BIN)/python -m pip install --quiet --no-deps --force-reinstall dist/*.whl
	rm -rf build
	touch $@

clean:
	rm -rf $(VENV) build dist out
