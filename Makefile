# Two commands on a fresh machine: `make demo` and `make test`. Both set up what they need in .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
STAMP_DEV := $(VENV)/.installed-dev
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint packaging/locked.txt
WORKERS ?= 2

.PHONY: demo test test-all sanitize wheel wheel-test fuzz check docs bench askable bench-scaling bench-micro bench-loading bench-poses bench-peers bench-solvers bench-versions bench-moving bench-clouds bench-execution bench-unproven bench-driving bench-perception bench-servo bench-threads bench-cold bench-bundles clean

demo: $(STAMP)
	$(BIN)/trajopt demo --out out/demo

test: $(STAMP_DEV) check
	$(BIN)/python -m pytest -n $(WORKERS) -m "not slow"

test-all: $(STAMP_DEV) check sanitize
	$(BIN)/python -m pytest -n $(WORKERS)

# The C++ tests of the native cores under the address and undefined-behaviour sanitizers.
sanitize: $(STAMP_DEV)
	$(MAKE) -C tests/native PYTHON=$(abspath $(BIN)/python)

# A source distribution, and from it a wheel with an honest tag; dist/.
wheel: $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check build wheel
	rm -rf dist
	$(BIN)/python -m build
	$(BIN)/python packaging/glibc_tag.py dist/*.whl

# The wheel in a fresh environment without a compiler, with the README's first plan.
wheel-test: wheel
	$(BIN)/python packaging/try_wheel.py dist/*.whl

# Thousands of random problems, judged by code of its own; goes on where it was stopped (rows in out/fuzz).
# OPTIONS: those of tests/fuzz/random_problems/__main__.py, such as --families mimic_chain --count 100.
fuzz: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.fuzz.random_problems --out out/fuzz --workers $(WORKERS) $(OPTIONS)

# Pin what pip would install today, to be committed once the tests pass with it.
.PHONY: lock
lock: $(VENV)/bin/python
	$(BIN)/python packaging/lock.py packaging/locked.txt

check: $(STAMP_DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python

# compas_fab's own integration tests and example scripts, unmodified, against `trajopt serve`; TESTS: a folder with them,
# as tests/ros/rosbridge/their_tests.py says. On the ports that they ask for: 9090, 9091 and 9190.
.PHONY: compas-fab
compas-fab: $(STAMP_DEV)
	$(BIN)/python -m tests.ros.rosbridge.their_tests $(TESTS)

# Pages with the notebooks as they run, the reference and the decisions: out/docs/index.html.
docs: $(STAMP)
	$(INSTALL) -e ".[docs]"
	$(BIN)/sphinx-build -W --keep-going -b html docs out/docs

# Each writes its section of benchmarks/README.md and its numbers in benchmarks/results/.
# DATA: a folder with panda/<set>/, ur5/<set>/, fetch/<set>/ and baxter/<set>/ of MotionBenchMaker scenes and requests,
# and ur5/robot/, fetch/robot/ and baxter/robot/. Goes on where it was stopped (rows in out/bench).
# OPTIONS: those of benchmarks/motion_bench_maker.py, such as --robots panda,fetch --limit 3.
bench: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.motion_bench_maker $(DATA) --results benchmarks/results \
	  --page benchmarks/README.md $(OPTIONS)

# Which of a robot's problems anybody could answer, by code that knows nothing of the planner. ROBOT: fetch, ...
askable: $(STAMP)
	$(BIN)/python -m benchmarks.askable $(DATA)/$(ROBOT)

bench-scaling: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.scaling --page benchmarks/README.md

# Among what moves: boxes that cross MotionBenchMaker's motions, cubes that bounce around an xArm7, and baselines. Goes
# on where it was stopped (rows in out/moving). All of it takes many hours of one core. OPTIONS: those of
# benchmarks/moving, such as --parts crossing,known --every 5, or --parts cubes --tests 10.
bench-moving: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check ompl==2.0.1
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.moving $(DATA) --results benchmarks/results/moving.jsonl \
	  --page benchmarks/README.md $(OPTIONS)

# The Panda's problems as clouds of points, beside the same with primitives and OMPL. Goes on where it was stopped (rows in
# out/clouds). OPTIONS: --every N, --ompl N, --parity N.
bench-clouds: $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check ompl==2.0.1
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.clouds $(DATA) --page benchmarks/README.md $(OPTIONS)

# Boxes appear in the way of simulated robots. OPTIONS: --runs N, of each of five problems.
bench-execution: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.execution --page benchmarks/README.md $(OPTIONS)

# Stops that cannot be proven in worlds that change in each cycle. OPTIONS: --runs N, of each of four problems.
bench-unproven: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.unproven_stops --json benchmarks/results/unproven_stops.json \
	  --page benchmarks/README.md $(OPTIONS)

# `kill -9` among a thousand writes of two processes, and what keeping and finding cost.
.PHONY: bench-warehouse
bench-warehouse: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.warehouse --page benchmarks/README.md $(OPTIONS)

# Campaigns ten times as large each, and faults in their midst, on this machine and on a Ray cluster of two nodes of one
# core. Mounts a small disk, so as root. OPTIONS: --counts 1000,10000; --tables writes the tables of what was measured.
.PHONY: bench-campaign
bench-campaign: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.campaign --page benchmarks/README.md $(OPTIONS)

# MotionBenchMaker planned again after every object was moved a little, with and without experience.
.PHONY: bench-experience
bench-experience: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.experience $(DATA) --results benchmarks/results/experience.jsonl \
	  --page benchmarks/README.md $(OPTIONS)

bench-server: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.server --page benchmarks/README.md $(OPTIONS)

# Policies behind the guard, beside a check of each waypoint and a clamp. OPTIONS: --episodes N, --seed N.
.PHONY: bench-guard
bench-guard: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.guard --page benchmarks/README.md $(OPTIONS)

# Robots that differ from their description. OPTIONS: --every K, --robots N.
.PHONY: bench-model-error
bench-model-error: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.model_error $(DATA) --page benchmarks/README.md $(OPTIONS)

# Whole tasks: the order of many holes, and a tray of parts. OPTIONS: --holes N, --parts N.
.PHONY: bench-tasks
bench-tasks: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.tasks --page benchmarks/README.md $(OPTIONS)

# Process paths: rows on a wall with arm and base, a raster and seams on a mesh.
.PHONY: bench-process-paths
bench-process-paths: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.process_paths --page benchmarks/README.md

# Random problems of the robots in FILES (URDF or xacro), whose packages are in PACKAGES.
.PHONY: bench-unseen
bench-unseen: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.unseen_robots $(FILES) --package-dir $(PACKAGES) --page benchmarks/README.md

# Bundles, warehouses and rows of campaigns with flipped bits, zeroed sectors and cut ends. OPTIONS: --each N.
.PHONY: bench-damaged
bench-damaged: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.damaged_files --page benchmarks/README.md $(OPTIONS)

# Hostile requests while workers are killed. OPTIONS: --requests N, --kills N, --seed N.
.PHONY: bench-hostile
bench-hostile: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.hostile --page benchmarks/README.md $(OPTIONS)

# Depth images to scenes, the camera in MuJoCo, and shelves that nobody knows. OPTIONS: --shelves N, --cell 0.01.
bench-perception: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.perception $(DATA) --page benchmarks/README.md $(OPTIONS)

# The servo beside mink on the same streams of commands. OPTIONS: --seeds N, of each of two robots.
bench-servo: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.servo --page benchmarks/README.md $(OPTIONS)

# Thousands of runs with surprises; goes on where it was stopped (rows in out/driving). OPTIONS: --runs N, --beside N,
# --beyond N.
bench-driving: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.driving --page benchmarks/README.md $(OPTIONS)

bench-poses: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.pose_goals $(DATA) --page benchmarks/README.md

bench-loading: $(STAMP)
	$(BIN)/python -m benchmarks.loading --page benchmarks/README.md

# Side by side with an older version: OLD is the interpreter of an environment in which it is installed.
bench-versions: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.versions $(DATA) --old $(OLD) --page benchmarks/README.md $(OPTIONS)

# Bundles: replayed to the last digit, hostile ones refused and at what cost, and what reports take.
bench-bundles: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.bundles --page benchmarks/README.md

# A process from its beginning; OLD, where given, is the interpreter of an environment with an older version.
bench-cold: $(STAMP)
	$(BIN)/python -m benchmarks.cold_start $(DATA) $(if $(OLD),--old $(OLD)) --page benchmarks/README.md $(OPTIONS)

bench-threads: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.threads $(DATA) --page benchmarks/README.md $(OPTIONS)

bench-micro: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.micro --page benchmarks/README.md

# Every method on the suite and on five problems of each Panda set; an hour of one core. Delete out/solvers to measure
# anew. OPTIONS: those of benchmarks/solvers.py, such as --solver chomp.
bench-solvers: $(STAMP_DEV)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.solvers $(DATA) --page docs/solvers.md $(OPTIONS)

# Side by side with other planners, each in an environment of its own below out/peers; about 20 minutes of one
# core. OPTIONS: those of benchmarks/peers/compare.py, such as --limit 2.
bench-peers: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.peers.compare --data $(DATA)/panda \
	  --page benchmarks/README.md $(OPTIONS)

$(VENV)/bin/python:
	$(PYTHON) -c 'import sys; sys.exit(not ((3, 11) <= sys.version_info[:2] <= (3, 13)))' \
	  || (echo "trajopt needs Python 3.11 to 3.13; name one with: make PYTHON=python3.12 ..." && exit 1)
	$(PYTHON) -m venv $(VENV)

SOURCES := pyproject.toml packaging/locked.txt $(shell find trajopt/native -name "*.[ch]pp" -o -name CMakeLists.txt)

$(STAMP): $(VENV)/bin/python $(SOURCES)
	$(INSTALL) -e ".[robots,view]"
	touch $@

# Does not rest on the other stamp, which it sets too: each installation compiles the native cores.
$(STAMP_DEV): $(VENV)/bin/python $(SOURCES)
	$(INSTALL) -e ".[dev]"
	touch $(STAMP) $@

clean:
	rm -rf $(VENV) out build dist *.egg-info
