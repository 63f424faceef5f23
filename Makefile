# make demo: repair a real incomplete scan and look at it.   make test: every check.
# make bench: time, memory and quality of the Power Crust beside its peers.
# make sdist, make wheel: what is released, in dist/, and checked.
# make test-oldest: every test with the oldest version of each dependency (OLDEST_PYTHON=python3.10).
# make sanitize: the kernel's tests, on a build that stops at wrong addresses and undefined operations.
# make fuzz: hostile input for the kernel, SEEDS=2000 calls.
# make gallery: the pictures of the documents (some need Chromium, or SYMRECON_DATA).
# Needs Python 3.10 or newer, a C++17 compiler and make; everything else goes into .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml $(shell find meshlab_symrecon filters -name '*.py' -o -name '*.?pp' -o -name 'CMakeLists.txt' -o -name '*.json' -o -name '*.pyi' -o -name '*.html' -o -name '*.css' -o -name '*.js')
DEMO := demo_output
OLDEST_PYTHON ?= python3.10
OLDEST := $(VENV)/oldest
RELEASE := $(VENV)/release

SANITIZED := build/sanitize
SEEDS ?= 2000
# The tests of the kernel and the algorithms; pymeshlab is no part of them.
KERNEL_TESTS := tests/geometry tests/clustering tests/symmetry tests/powercrust tests/test_arrays.py \
  tests/test_native_types.py tests/test_hostile_arrays.py

.PHONY: demo test lint unit bench sanitize fuzz docs gallery sdist wheel test-oldest clean

demo: $(VENV)/installed
	mkdir -p $(DEMO)
	$(BIN)/symrecon reconstruct examples/data/nefertiti_incomplete.ply \
	  -o $(DEMO)/nefertiti_statue.ply --project $(DEMO)/nefertiti.mlp \
	  --json $(DEMO)/nefertiti.json --preview $(DEMO)/nefertiti.png \
	  --report $(DEMO)/nefertiti.html
	@echo
	@echo "The statue:   $(DEMO)/nefertiti_statue.ply"
	@echo "All layers:   $(DEMO)/nefertiti.mlp  (open it in MeshLab)"
	@echo "The picture:  $(DEMO)/nefertiti.png"
	@echo "The report:   $(DEMO)/nefertiti.html  (open it in a browser)"

test: lint unit

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

unit: $(VENV)/installed-dev
	$(BIN)/pytest

bench: $(VENV)/installed-dev
	$(BIN)/python benchmarks/power_crust.py

# The sanitized package shadows the installed one. Leaks are not looked for: Python leaves memory behind on purpose.
# Python's own allocator would hide what is read behind an array, so memory comes from the sanitizer's.
# The sanitizer needs the C++ library beside it, which Python alone does not load.
SANITIZE := LD_PRELOAD="$(shell g++ -print-file-name=libasan.so) $(shell g++ -print-file-name=libstdc++.so)" \
  ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 \
  PYTHONMALLOC=malloc OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 PYTHONPATH=$(CURDIR)/$(SANITIZED)/site

sanitize: $(SANITIZED)/installed
	cd $(SANITIZED) && $(SANITIZE) $(abspath $(BIN))/python -c \
	  "from meshlab_symrecon import _native; assert '$(SANITIZED)' in _native.__file__, _native.__file__"
	$(SANITIZE) $(BIN)/pytest -q $(KERNEL_TESTS)

fuzz: $(VENV)/installed-dev
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/fuzz_kernel.py --seeds $(SEEDS)

$(SANITIZED)/installed: $(SOURCES) $(VENV)/installed-dev
	rm -rf $(SANITIZED)/site
	CXX=g++ $(BIN)/pip install --quiet --disable-pip-version-check --no-deps --target $(SANITIZED)/site \
	  -C cmake.define.SYMRECON_SANITIZE=ON -C cmake.build-type=RelWithDebInfo -C build-dir=$(SANITIZED)/cmake .
	touch $@

docs: $(VENV)/installed-dev
	$(BIN)/symrecon filters --pages docs

gallery: $(VENV)/installed-dev
	$(BIN)/python docs/gallery.py

# Archives carry the time of the last change, not of the build: two builds are the same bytes.
sdist wheel: export SOURCE_DATE_EPOCH ?= $(shell git log -1 --format=%ct 2>/dev/null || echo 1704067200)

# Built twice; then installed without a network beside nothing but what builds it.
sdist: $(RELEASE)/installed
	rm -rf dist/*.tar.gz $(RELEASE)/again
	$(RELEASE)/bin/python -m build --sdist --outdir dist .
	$(RELEASE)/bin/python -m build --sdist --outdir $(RELEASE)/again .
	cmp dist/*.tar.gz $(RELEASE)/again/*.tar.gz
	$(RELEASE)/bin/twine check --strict dist/*.tar.gz
	PIP_NO_INDEX=1 $(RELEASE)/bin/pip install --no-build-isolation --no-deps --force-reinstall dist/*.tar.gz
	cd / && $(abspath $(RELEASE))/bin/python -c "import meshlab_symrecon._native"

# From the archive; then tested in an environment of its own.
wheel: sdist
	rm -rf dist/*.whl $(RELEASE)/empty
	$(RELEASE)/bin/pip wheel --no-deps --wheel-dir dist dist/*.tar.gz
	$(RELEASE)/bin/twine check --strict dist/*.whl
	$(RELEASE)/bin/check-wheel-contents dist/*.whl
	case "$$(ls dist/*.whl)" in *abi3*) $(RELEASE)/bin/abi3audit --strict dist/*.whl;; esac
	$(PYTHON) -m venv $(RELEASE)/empty
	$(RELEASE)/empty/bin/pip install --quiet --disable-pip-version-check pytest dist/*.whl
	$(RELEASE)/empty/bin/pytest tests/test_installed.py tests/test_arrays.py

test-oldest:
	test -x $(OLDEST)/bin/python || $(OLDEST_PYTHON) -m venv $(OLDEST)
	$(OLDEST)/bin/pip install --quiet --disable-pip-version-check -c tests/oldest_versions.txt ".[dev,distributed,report]"
	$(OLDEST)/bin/pytest

$(RELEASE)/installed: pyproject.toml
	test -x $(RELEASE)/bin/python || $(PYTHON) -m venv $(RELEASE)
	$(RELEASE)/bin/pip install --quiet --disable-pip-version-check build twine abi3audit check-wheel-contents \
	  "scikit-build-core>=0.10" "nanobind>=2.2" "cmake>=3.26" ninja
	touch $@

# The installed package is what is used and tested, not the tree.
$(VENV)/installed: $(SOURCES)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check ".[report]"
	touch $@

$(VENV)/installed-dev: $(SOURCES)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check ".[dev,report]"
	touch $@ $(VENV)/installed

clean:
	rm -rf $(VENV) $(DEMO) build dist
