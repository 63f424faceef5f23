# make demo: repair a real incomplete scan and look at it.   make test: every check.
# make bench: time, memory and quality of the Power Crust beside its peers.
# make gallery: the pictures of the documents (some need Chromium, or SYMRECON_DATA).
# Needs Python 3.10 or newer, a C++17 compiler and make; everything else goes into .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SOURCES := pyproject.toml $(shell find meshlab_symrecon filters -name '*.py' -o -name '*.?pp' -o -name 'CMakeLists.txt' -o -name '*.json' -o -name '*.pyi' -o -name '*.html' -o -name '*.css' -o -name '*.js')
DEMO := demo_output

.PHONY: demo test lint unit bench docs gallery clean

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

docs: $(VENV)/installed-dev
	$(BIN)/symrecon filters --pages docs

gallery: $(VENV)/installed-dev
	$(BIN)/python docs/gallery.py

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
