PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/installed

.PHONY: demo dataset-demo test lint fuzz kernels-checked bench study examples wheel clean

demo: $(INSTALLED)  ## render the Cornell box into out/
	mkdir -p out
	$(BIN)/python -m photonmap scenes/cornell_box.obj --bands 6 --output out/cornell_box.exr
	@echo "the picture: $(CURDIR)/out/cornell_box.png"

dataset-demo: $(INSTALLED)  ## a data set of 4 scenes in 4 lights into out/dataset-demo/
	mkdir -p out
	rm -rf out/dataset-demo
	$(BIN)/python -m photonmap dataset out/dataset-demo --preset small --size 96x72 --error 0.05
	@echo "the contact sheet: $(CURDIR)/out/dataset-demo/report.html"

test: $(INSTALLED)  ## lint, then every test
	$(MAKE) lint
	$(BIN)/python -m pytest

lint: $(INSTALLED)  ## format, style, types
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

SEED ?= $(shell date +%s)
COUNT ?= 100
fuzz: $(INSTALLED)  ## random scenes and damaged files: COUNT of each, from SEED; the largest cases
	@echo "make fuzz SEED=$(SEED) COUNT=$(COUNT)"
	PHOTONMAP_SEED=$(SEED) PHOTONMAP_EXAMPLES=$(COUNT) PHOTONMAP_TRIANGLES=5000000 PHOTONMAP_SIDE=8192 \
		$(BIN)/python -m pytest tests/hard

kernels-checked: $(INSTALLED)  ## every kernel once with bounds checked, and once as plain Python
	NUMBA_BOUNDSCHECK=1 NUMBA_CACHE_DIR=out/kernels-checked $(BIN)/python tests/hard/checked.py
	NUMBA_DISABLE_JIT=1 $(BIN)/python tests/hard/checked.py

examples: $(INSTALLED)  ## run every example into out/
	mkdir -p out
	for example in examples/*.py; do (cd out && ../$(BIN)/python ../$$example) || exit 1; done

bench: $(INSTALLED)  ## print the tables of docs/performance.md
	$(BIN)/pip install --quiet --constraint constraints.txt --editable ".[bench]"
	$(BIN)/python -m benchmarks

study: $(INSTALLED)  ## measure what accuracy costs on the Cornell box into docs/study/
	$(BIN)/python -m photonmap study scenes/cornell_box.obj --minutes 12 --output docs/study

wheel: $(INSTALLED)  ## build a wheel and try it outside the checkout
	$(BIN)/pip wheel --quiet --no-deps --wheel-dir out .
	$(PYTHON) -m venv out/wheel-venv
	out/wheel-venv/bin/pip install --quiet --constraint constraints.txt out/photonmap-*.whl
	cd out && wheel-venv/bin/python -m photonmap \
		$$(wheel-venv/bin/python -c "import photonmap.scenes as s; print(s.FOLDER)")/cornell_box.obj \
		--size 32x32 --passes 2 --output wheel.exr
	cd out && wheel-venv/bin/python -c "import importlib.util as u; assert not u.find_spec('kernels')"

clean:
	rm -rf .venv out build *.egg-info

# Installing needs pyproject.toml alone; an edit of the sources needs nothing.
$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --upgrade pip
	$(BIN)/pip install --quiet --constraint constraints.txt --editable ".[dev]"
	touch $@
