PYTHON ?= python3
BIN := .venv/bin
RUNNABLE := .venv/runnable
INSTALLED := .venv/installed

# Python and pytest keep compiled sources: a suite that starts a hundred processes lives on them.
unexport PYTHONDONTWRITEBYTECODE

# Runs a command without its output, which is shown if it fails.
QUIETLY := sh -c 'log=$$(mktemp); "$$@" > $$log 2>&1 || { code=$$?; cat $$log; rm $$log; exit $$code; }; rm $$log' quietly

.PHONY: docs gallery golden demo dataset-demo test test-all test-slow lint style fuzz kernels-checked kernels-bounds kernels-plain bench study examples wheel release-check clean

demo: $(RUNNABLE)  ## render the Cornell box into out/
	@mkdir -p out
	@echo "rendering scenes/cornell_box.obj; the first time, kernels are compiled for some 15 seconds"
	@$(QUIETLY) $(BIN)/python -m photonmap scenes/cornell_box.obj --bands 6 --passes 4 --output out/cornell_box.exr
	@echo "the picture: $(CURDIR)/out/cornell_box.png"

dataset-demo: $(INSTALLED)  ## a data set of 4 scenes in 4 lights into out/dataset-demo/
	mkdir -p out
	rm -rf out/dataset-demo
	$(BIN)/python -m photonmap dataset out/dataset-demo --preset small --size 96x72 --error 0.05
	@echo "the contact sheet: $(CURDIR)/out/dataset-demo/report.html"

WORKERS ?= 2
PARALLEL := --numprocesses $(WORKERS)
test: $(INSTALLED)  ## lint, then the tests that matter: minutes
	$(MAKE) style
	$(BIN)/python -m photonmap compile --quiet
	$(BIN)/python -m pytest $(PARALLEL) -m "not slow"

test-all: $(INSTALLED)  ## lint, then every test
	$(MAKE) style
	$(BIN)/python -m pytest $(PARALLEL)

test-slow: $(INSTALLED)  ## what `make test` leaves out
	$(BIN)/python -m pytest $(PARALLEL) -m slow

lint: style  ## format, style, types, sizes, imports
	$(BIN)/python -m pytest tests/test_sizes.py tests/test_imports.py

style: $(INSTALLED)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

SEED ?= $(shell date +%s)
COUNT ?= 100
fuzz: $(INSTALLED)  ## random scenes and damaged files: COUNT of each, from SEED; the largest cases
	@echo "make fuzz SEED=$(SEED) COUNT=$(COUNT)"
	PHOTONMAP_SEED=$(SEED) PHOTONMAP_EXAMPLES=$(COUNT) PHOTONMAP_TRIANGLES=5000000 PHOTONMAP_SIDE=8192 \
		$(BIN)/python -m pytest tests/hard

fuzz-%: $(INSTALLED)  ## 10 × COUNT files of one reader, such as fuzz-gltf, that are wrong in what they say
	@echo "make $@ SEED=$(SEED) COUNT=$(COUNT)"
	PHOTONMAP_SEED=$(SEED) PHOTONMAP_EXAMPLES=$(COUNT) \
		$(BIN)/python -m pytest tests/hard/test_structures.py -k $*

kernels-checked: kernels-bounds kernels-plain  ## every kernel once with bounds checked, and as plain Python

kernels-bounds: $(INSTALLED)
	NUMBA_BOUNDSCHECK=1 NUMBA_CACHE_DIR=out/kernels-checked $(BIN)/python tests/hard/checked.py

kernels-plain: $(INSTALLED)
	NUMBA_DISABLE_JIT=1 $(BIN)/python tests/hard/checked.py

golden: $(INSTALLED)  ## record the golden images anew, after a change of arithmetic on purpose
	$(BIN)/python tests/golden/golden_record.py

examples: $(INSTALLED)  ## run every example into out/
	mkdir -p out
	for example in examples/*.py; do (cd out && ../$(BIN)/python ../$$example) || exit 1; done

bench: $(INSTALLED)  ## print the tables of docs/performance.md
	@$(QUIETLY) $(BIN)/pip install --constraint constraints.txt --editable ".[bench]"
	$(BIN)/python -m benchmarks

study: $(INSTALLED)  ## measure what accuracy costs on the Cornell box into docs/study/
	$(BIN)/python -m photonmap study scenes/cornell_box.obj --minutes 12 --output docs/study

docs: $(INSTALLED)  ## the site of the documentation into out/site, without a warning
	$(BIN)/python tools/make_site.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	@echo "the site: $(CURDIR)/out/site/index.html"

gallery: $(INSTALLED)  ## render the pictures of docs/gallery.md
	$(BIN)/python tools/make_gallery.py

wheel: $(INSTALLED)  ## build a wheel that brings compiled kernels, and try it outside the checkout
	@mkdir -p out
	$(BIN)/python tools/make_wheel.py out
	@$(QUIETLY) $(PYTHON) -m venv out/wheel-venv
	@$(QUIETLY) out/wheel-venv/bin/pip install --constraint constraints.txt out/photonmap-*.whl
	cd out && wheel-venv/bin/python -m photonmap \
		$$(wheel-venv/bin/python -c "import photonmap.scenes as s; print(s.FOLDER)")/cornell_box.obj \
		--size 32x32 --passes 2 --output wheel.exr
	cd out && wheel-venv/bin/python -c "import importlib.util as u; assert not u.find_spec('kernels')"

COMPILED ?=
release-check: $(INSTALLED)  ## build what is published, and try it in empty environments; COMPILED=yes: with kernels
	$(BIN)/python tools/check_release.py out/release $(if $(COMPILED),--compiled)

clean:
	rm -rf .venv out build *.egg-info

# Installing needs pyproject.toml alone; an edit of the sources needs nothing. Python compiles what it
# imports; the rest of all packages would take a demo ten seconds.
$(RUNNABLE): pyproject.toml constraints.txt
	@echo "installing into .venv"
	@$(QUIETLY) $(PYTHON) -m venv .venv
	@$(QUIETLY) $(BIN)/pip install --no-compile --constraint constraints.txt --editable .
	@touch $@

$(INSTALLED): $(RUNNABLE)
	@echo "installing what tests need into .venv"
	@$(QUIETLY) $(BIN)/pip install --upgrade pip
	@$(QUIETLY) $(BIN)/pip install --no-compile --constraint constraints.txt --editable ".[dev]"
	@touch $@
