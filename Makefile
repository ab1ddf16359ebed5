# The two commands of the README. Both make .venv from pinned versions first.
CORES ?= 2
PYTHON ?= python3
BIN = .venv/bin
# a file whose keys replace those of config.yaml: make reproduce STUDY=config/short.yaml
STUDY ?=
CONFIG = $(if $(STUDY),--config "study=$(STUDY)")
# where jobs run, if not on this machine: make reproduce PROFILE=profiles/slurm (docs/cluster.md)
PROFILE ?=
WHERE = $(if $(PROFILE),--profile $(PROFILE),--cores $(CORES))

.PHONY: reproduce test oldest lint docs site reference benchmark verify clean

reproduce: .venv/ready
	$(BIN)/snakemake $(WHERE) $(CONFIG)
	$(BIN)/snakemake --cores $(CORES) $(CONFIG) --report results/report.html

test: .venv/ready
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses $(CORES) --dist worksteal

# the tests with the oldest dependencies that pyproject.toml allows, in an environment of their own
oldest:
	$(PYTHON) -m venv .venv/oldest
	sed -n 's/^  "\(.*\)>=\(.*\)",$$/\1==\2/p' pyproject.toml > .venv/oldest/constraints.txt
	.venv/oldest/bin/python -m pip install --quiet --constraint .venv/oldest/constraints.txt --editable .[test]
	OMP_NUM_THREADS=1 .venv/oldest/bin/python -m pytest --numprocesses $(CORES) -m "not workflow and not report" --ignore tests/docs $(TESTS)
	OMP_NUM_THREADS=1 .venv/oldest/bin/python -m pytest --numprocesses $(CORES) tests/workflow/test_runs.py tests/workflow/test_use_as_module.py

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow/Snakefile workflow/rules
	$(BIN)/snakemake --lint

# the pages of docs/ that quote results, from those of make reproduce STUDY=config/convergence.yaml, and the site
docs: .venv/ready
	$(BIN)/python docs/write.py
	$(MAKE) site

# results/site/index.html, without results and without a network; its examples run once, and again after an edit
site: .venv/ready
	OMP_NUM_THREADS=1 $(BIN)/sphinx-build --fail-on-warning --keep-going --quiet --doctree-dir results/site-cache docs results/site
	@echo "Open results/site/index.html"

# schemas of the YAML files, and the tables of their keys in config/README.md
reference: .venv/ready
	$(BIN)/python -m boltjoint.config.reference
	$(BIN)/python docs/options.py

# times of all stages and solvers, docs/benchmarks.md, and what is slower than in its last table
THREE_BOLTS = $(addprefix results/cases/three_bolt_,$(1:%=%/joint.nc))
TIMED = $(call THREE_BOLTS, \
	constant/free-4/node-to-node constant/free-4/regions=6 constant/free-4/regions=6/elements=7 \
	constant/free-4/regions=6/table constant/free-4/regions=6/iwan \
	variable/free-4/node-to-node variable/free-4/regions=12/elements=4 \
	$(foreach law,constant variable,$(law)/enriched-40/node-to-node $(law)/enriched-40/hyper=auto))
benchmark: .venv/ready
	$(BIN)/snakemake --cores $(CORES) $(TIMED)
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest benchmarks --benchmark-json results/benchmarks/speed.json
	$(BIN)/python docs/benchmarks.py

# modes and contact found by CalculiX too, another finite-element program: of two shipped assemblies,
# or of a half lap or a deck of your own: make verify MODEL=beam
MODEL ?=
VERIFIED = $(or $(MODEL),three_bolt three_bolt_aluminium)
COMPARED = $(VERIFIED:%=results/verification/%/calculix.csv)
# a case that uses it tells its preload
CASE_OF = $(firstword $(notdir $(basename $(shell grep -lE '^assembly: *$(MODEL)( |$$)' config/cases/*.yaml))))
ITS_STUDY = $(if $(CASE_OF),"cases=[$(CASE_OF)]","assemblies=[$(MODEL)]") $(if $(STUDY),"study=$(STUDY)")
verify: .venv/ready
	@if ! command -v ccx >/dev/null; then \
		if [ "$$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then \
			echo "verify needs CalculiX (ccx): install calculix-ccx of Debian or Ubuntu, or calculix of conda-forge"; exit 1; \
		fi; \
		apt-get update && apt-get install --yes --no-install-recommends calculix-ccx; \
	fi
	$(BIN)/snakemake $(COMPARED) --cores $(CORES) --config $(if $(MODEL),$(ITS_STUDY),study=config/verify.yaml)
	@$(BIN)/python -c 'import pandas, sys; [print(pandas.read_csv(file).iloc[:, :5].to_string(index=False, na_rep="")) for file in sys.argv[1:]]' $(COMPARED)
	@! grep ',False$$' $(COMPARED) || { echo "CalculiX differs by more than the bound, see $(COMPARED:.csv=.html)"; exit 1; }

clean:
	rm -rf results .snakemake

.venv/ready: requirements.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "boltjoint needs Python 3.11 or newer; name one with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --require-hashes --requirement requirements.txt
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	touch $@
