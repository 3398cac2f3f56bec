# Two commands do everything on a fresh machine with Python >= 3.11: `make demo` and `make test`.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# Each process that the tests start would compile the package, and each worker every test, were nothing kept.
unexport PYTHONDONTWRITEBYTECODE
STAMP := $(VENV)/.installed
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: demo test test-product test-lab test-lab-long test-processors lab-bench lab-verify lab-blind wheel-check docs docs-tables lint lock clean

demo: $(STAMP)
	$(BIN)/python scripts/run_campaign.py --maneuver step_decrease --das 20/1

# The types are checked by one process, which would leave a core idle: the tests run beside it.
test: $(STAMP)
	$(MAKE) --jobs 2 lint test-product

# A file is the work of one worker, which shares its flights. The longest files are begun first, by tests/conftest.py.
# A worker that dies ends the run and its test is named: with a new worker in its place xdist 3.8 waits without end.
TESTS := -n 2 --dist loadfile --no-loadscope-reorder --max-worker-restart 0

test-product: $(STAMP)
	$(BIN)/python -m pytest $(TESTS) --ignore tests/lab

# The laboratory's own tests: it proves the product, and no user runs it. Those of more than a minute are
# run before a release.
test-lab: $(STAMP)
	$(BIN)/python -m pytest $(TESTS) -m "not long" tests/lab

test-lab-long: $(STAMP)
	$(BIN)/python -m pytest $(TESTS) -m long tests/lab

# The numeric tests as on an old processor: its BLAS kernels, and no vector code of NumPy above SSE4.2. What is text is
# left out, and so is what names a cause or tests/lab/recovery repeats over many flights.
# NumPy passes over names that it does not know: of 2.4 the levels, before it the single features.
NUMERIC := tests/processors.py tests/test_air.py tests/test_units.py tests/estimation \
  tests/pressure_error tests/effects tests/sensing tests/calibration tests/regression \
  --ignore tests/calibration/test_broken_pitots.py
NO_VECTORS := X86_V3 X86_V4 AVX512_ICL AVX512_SPR AVX2 FMA3 AVX512F AVX512_SKX
BOUNDED := timeout --kill-after=10 600

test-processors: $(STAMP)
	OPENBLAS_CORETYPE=Prescott NPY_DISABLE_CPU_FEATURES="$(NO_VECTORS)" $(BOUNDED) $(BIN)/python -m pytest $(TESTS) $(NUMERIC)

lint: $(STAMP)
	$(BIN)/ruff check src scripts tests
	$(BIN)/ruff format --check src scripts tests
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

# The site of docs/ in out/docs; a warning, also of a link that leads nowhere, is an error.
docs: $(STAMP)
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs out/docs
	@cp out/docs/README.html out/docs/index.html
	@echo "open out/docs/index.html"

# The tables of docs/ that repeat the code: effects, cards.
docs-tables: $(STAMP)
	$(BIN)/python -m pitotlab tables

lab-bench: $(STAMP)
	$(BIN)/python -m pitotlab speed

lab-verify: $(STAMP)
	$(BIN)/python -m pitotlab coverage

# The wheel in a fresh environment outside the checkout, used as a user does.
wheel-check: $(STAMP)
	$(BIN)/python -m tests.wheel --python $(PYTHON)

SEED ?= 900000
JOBS ?= 2
LAB := $(BIN)/python -m pitotlab

# Signatures, a sealed set, its answers, the score: in out/lab.
lab-blind: $(STAMP)
	$(LAB) blind signatures --jobs $(JOBS)
	$(LAB) blind generate --seed $(SEED) --jobs $(JOBS)
	$(LAB) blind analyze --jobs $(JOBS)
	$(LAB) blind pooled out/lab/blind

$(STAMP): pyproject.toml requirements.lock src/pitotbench/version.py
	@$(PYTHON) -c 'import sys; sys.exit("pitotbench needs Python 3.11 or newer; set PYTHON=...") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(PIP) --require-hashes -r requirements.lock
	$(PIP) --no-deps --no-build-isolation -e .
	@touch $@

# Every package with the hashes of all its files, for each Python and system: needs uv. What is locked stays as it is
# while it fits pyproject.toml: `make lock LOCK=--upgrade` takes the newest of all, LOCK='--upgrade-package numpy' of one.
lock:
	$(PYTHON) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["build-system"]["requires"], sep="\n")' \
	  | uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-annotate --no-header --no-emit-index-url \
	  --extra test --extra docs $(LOCK) --output-file requirements.lock pyproject.toml -

clean:
	rm -rf $(VENV) out .mypy_cache .ruff_cache .pytest_cache
