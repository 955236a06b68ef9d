# Two commands for a fresh machine with Python 3.11+: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.installed
OUT ?= out

.DEFAULT_GOAL := help
.PHONY: help install test demo checkpoints lint types contracts check gallery clean

help:
	@echo "make demo         install, then generate, benchmark, evaluate and write $(OUT)/demo/report.html"
	@echo "make test         install, then run the tests"
	@echo "make check        lint, types, import contracts"
	@echo "make checkpoints  train the shipped networks again (about 35 minutes on 2 cores; resumes)"
	@echo "make gallery      draw every weather and camera for docs/gallery.md"
	@echo "make clean        delete .venv, caches and $(OUT)"

install: $(READY)

$(READY): pyproject.toml constraints.txt
	@test -x $(BIN)/python || $(PYTHON) -c 'import sys; sys.exit("pedcross needs Python 3.11 or newer, this is " + sys.version.split()[0] + "; set PYTHON=python3.11") if sys.version_info < (3, 11) else 0'
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

test: $(READY)
	$(BIN)/python -m pytest

demo: $(READY)
	$(BIN)/pedcross demo --out $(OUT)/demo

checkpoints: $(READY)
	$(BIN)/pedcross checkpoints --out $(OUT)/checkpoints

gallery: $(READY)
	$(BIN)/python docs/make_gallery.py

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

contracts: $(READY)
	$(BIN)/lint-imports

check: lint types contracts

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .import_linter_cache $(OUT)
