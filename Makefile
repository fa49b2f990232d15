# shoecal without an installation of ROS: everything lives in .venv, build/ and install/.

.DEFAULT_GOAL := help
.PHONY: firmware stand-ins robots published descriptions clean-sessions help setup demo test test-floor lint bench planner-speed planned-motions live-path demo-table paper trust accuracy repeats caught-faults faults evidence blind closed-loop own-steps motion-menu figures gallery reference docs wheel lock clean

# Nothing that is sourced in the calling shell reaches what runs from .venv.
unexport AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH PYTHONHOME PYTHONPATH
unexport ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION RMW_IMPLEMENTATION

BIN := .venv/bin
FLOOR_PYTHON ?= python3.11
DOCS_PYTHON ?= python3
LOCK := $(BIN)/uv pip compile --quiet --upgrade --generate-hashes --no-annotate --no-emit-index-url \
	--custom-compile-command "make lock"

help:  ## list what can be made
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

setup:  ## build .venv and install/ (PYTHON=... names the interpreter)
	@scripts/setup.sh

demo: setup  ## the main job on the simulated robot (ARGS="--seed 2")
	$(BIN)/shoecal demo $(ARGS)

test: export OPENBLAS_NUM_THREADS := 1
test: setup stand-ins descriptions  ## all tests (ARGS="-k name")
	$(BIN)/python -m pytest -n auto --dist loadfile $(ARGS)

stand-ins: setup  ## messages of robots' drivers, for the tests of adapters
	@scripts/stand_ins.sh

test-floor: .venv-floor/.complete  ## core tests with the oldest versions, those of Ubuntu 24.04
	.venv-floor/bin/python -m pytest -n auto --dist loadfile test/core $(ARGS)

lint: setup  ## ruff and mypy
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	@scripts/still_running.sh mypy $(BIN)/mypy

# Each measurement has arguments of its own.
bench: override ARGS :=
bench: planner-speed live-path demo-table paper  ## all measurements

evidence: setup stand-ins descriptions  ## the tables of docs/evidence, in two hours (ARGS="paper")
	$(BIN)/python benchmarks/evidence.py $(ARGS)

planner-speed: export OPENBLAS_NUM_THREADS := 1
planner-speed: setup  ## the planner's solver against IPOPT, motions in many supports (ARGS="--supports 1 --nao 20")
	$(BIN)/python benchmarks/planner_speed.py $(ARGS)

planned-motions: export OPENBLAS_NUM_THREADS := 1
planned-motions: setup  ## load, grip and tilt of planned motions in the physics (ARGS="--robots nao --count 20")
	$(BIN)/python benchmarks/planned_motions.py $(ARGS)

live-path: export OPENBLAS_NUM_THREADS := 1
live-path: setup  ## latency from frame to CoP, compared with a bare chain (ARGS="--seconds 5")
	$(BIN)/python benchmarks/live_path.py $(ARGS)

demo-table: setup  ## the errors of the demo over ten seeds, into docs/evidence/demo.md (ARGS="--seeds 3")
	$(BIN)/python benchmarks/demo_seeds.py $(ARGS)

blind: export OPENBLAS_NUM_THREADS := 1
blind: setup  ## diagnosis of sets whose answers are sealed, into docs/evidence/diagnosis.md (ARGS="--seed 2")
	$(BIN)/python benchmarks/blind_check.py $(ARGS)

clean-sessions: export OPENBLAS_NUM_THREADS := 1
clean-sessions: setup  ## no false alarm on another robot, into docs/evidence/diagnosis.md (ARGS="--seeds 5")
	$(BIN)/python benchmarks/clean_sessions.py $(ARGS)

closed-loop: export OPENBLAS_NUM_THREADS := 1
closed-loop: setup  ## effects found, written into the robot's files, simulated again, into docs/evidence/diagnosis.md (ARGS="--seeds 2")
	$(BIN)/python benchmarks/closed_loop.py $(ARGS)

own-steps: export OPENBLAS_NUM_THREADS := 1
own-steps: setup  ## walks by own steps in the physics, into docs/evidence/own-steps.md (ARGS="--seeds 2")
	$(BIN)/python benchmarks/own_steps.py $(ARGS)

motion-menu: setup  ## every motion of the menu and how long it takes, into docs/reference/motions.md
	$(BIN)/python benchmarks/motion_menu.py

paper: setup  ## the paper's evaluation over ten robots, into docs/evidence/paper.md (ARGS="--seeds 20")
	$(BIN)/python benchmarks/paper.py $(ARGS)

trust: accuracy repeats caught-faults  ## what trust in a calibration rests on, into docs/evidence/trust.md

accuracy: export OPENBLAS_NUM_THREADS := 1
accuracy: setup  ## errors of a calibration, and do stated ones hold? (ARGS="--seeds 2 --realities default")
	$(BIN)/python benchmarks/accuracy.py $(ARGS)

repeats: export OPENBLAS_NUM_THREADS := 1
repeats: setup  ## one robot calibrated again and again (ARGS="--repeats 5")
	$(BIN)/python benchmarks/repeats.py $(ARGS)

caught-faults: export OPENBLAS_NUM_THREADS := 1
caught-faults: setup  ## faults put into recordings, how many are caught (ARGS="--draws 5 --clean 10")
	$(BIN)/python benchmarks/caught_faults.py $(ARGS)

faults: export OPENBLAS_NUM_THREADS := 1
faults: setup stand-ins  ## every fault very often, into docs/evidence/reliability.md (ARGS="--share 0.1")
	$(BIN)/python benchmarks/faults.py $(ARGS)

figures: setup  ## the figures of README, conventions and motions, into docs/figures
	$(BIN)/python scripts/figures.py

gallery: setup  ## the pictures of the examples, into docs/images
	$(BIN)/python scripts/gallery.py

reference: setup  ## docs/reference, from the code (ARGS=--check)
	$(BIN)/python scripts/make_reference.py $(ARGS)

docs: .venv-docs/.complete  ## the documentation as a site, into out/site
	.venv-docs/bin/python -m sphinx -W --keep-going -q -b html docs out/site

wheel: setup  ## a wheel of shoecal_core, into out/wheel
	$(BIN)/python -m pip --disable-pip-version-check wheel --quiet --no-deps --no-build-isolation \
		--wheel-dir out/wheel ./shoecal_core
	rm -rf shoecal_core/build

firmware:  ## firmware of a shoe, and more (ARGS="flash PORT=/dev/ttyUSB0", ARGS=host)
	@$(MAKE) --no-print-directory -C firmware $(ARGS)

robots: export OPENBLAS_NUM_THREADS := 1
robots: setup descriptions  ## public humanoids drafted, planned and calibrated, into docs/evidence/robots.md (ARGS="--only g1")
	$(BIN)/python benchmarks/public_robots.py $(ARGS)

published: export OPENBLAS_NUM_THREADS := 1
published: setup  ## humanoids as published, taken through all commands, into docs/evidence/robots.md (ARGS="FOLDER" of clones)
	$(BIN)/python benchmarks/published_robots.py $(ARGS)

descriptions: setup .venv/.descriptions  ## descriptions of public humanoids, for tests and figures

.venv/.descriptions: requirements-robots.txt
	@scripts/still_running.sh descriptions scripts/install_lock.sh .venv $<
	@touch $@

lock: setup  ## resolve the lock files anew
	$(LOCK) --universal --fork-strategy fewest --python-version 3.11 \
		--output-file requirements.txt requirements.in shoecal_core/setup.py shoecal_ros/setup.py
	$(LOCK) --override requirements-floor.in --python-version 3.11 \
		--python-platform x86_64-manylinux_2_35 \
		--output-file requirements-floor.txt requirements-floor.in shoecal_core/setup.py \
		shoecal_ros/setup.py
	$(LOCK) --universal --python-version 3.11 \
		--output-file requirements-docs.txt requirements-docs.in

clean:  ## remove all that was built, but no results (out/)
	rm -rf .venv .venv-docs .venv-floor build install log .hypothesis .mypy_cache .pytest_cache .ruff_cache
	rm -rf shoecal_core/*.egg-info shoecal_ros/*.egg-info
	find shoecal_core shoecal_ros test scripts -name __pycache__ -type d -prune -exec rm -rf {} +

.venv-floor/.complete: requirements-floor.txt
	@command -v $(FLOOR_PYTHON) >/dev/null || { echo "test-floor: $(FLOOR_PYTHON) is missing;" \
		"install Python 3.11 or name it: make test-floor FLOOR_PYTHON=PATH" >&2; exit 1; }
	$(FLOOR_PYTHON) -m venv --clear .venv-floor
	@scripts/still_running.sh test-floor scripts/install_lock.sh .venv-floor $<
	realpath shoecal_core >$$(echo .venv-floor/lib/python3.*/site-packages)/shoecal_core.pth
	touch $@

.venv-docs/.complete: requirements-docs.txt
	$(DOCS_PYTHON) -m venv --clear .venv-docs
	@scripts/still_running.sh docs scripts/install_lock.sh .venv-docs $<
	touch $@
