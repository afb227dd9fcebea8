# Farhand. `make run` and `make test` set up what they need by themselves.
PYTHON ?= python3
PORT ?= 8000
PY = .venv/bin/python
TEST = PYTHONPATH=. $(PY) -m pytest
SIDE_BY_SIDE = --dist loadfile --no-loadscope-reorder
GATE = not timed and not length
SERVICES = tests/services tests/faults
unexport PYTHONDONTWRITEBYTECODE

.NOTPARALLEL:
.PHONY: wheel run setup setup-test setup-all lerobot quick world test test-node test-sqlite test-postgres test-all test-lerobot check bench proofs mutants asvs soak shots lock clean

run: setup
	@exec $(PY) manage.py demo --port $(PORT)

setup:
	@$(PYTHON) tools/setup.py run

setup-test:
	@$(PYTHON) tools/setup.py test

setup-all:
	@$(PYTHON) tools/setup.py all

# LeRobot's robots, an optional extra.
lerobot:
	@$(PYTHON) tools/setup.py lerobot

# In a minute: linters, types, the front end's tests, the tests nearest to the changes, and a robot in virtual time.
quick: setup-test
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy .
	$(PY) tools/run_node_tests.py
	FARHAND_TEST_DB=sqlite PYTHONPATH=. $(PY) tools/quick.py $(SIDE_BY_SIDE) -n 2 --timeout 900 -m "$(GATE)"
	FARHAND_TEST_DB=sqlite $(TEST) tests/world -k smoke -m "$(GATE)"

# Robots, owners and people in virtual time, at length; or one seed again: make world SEED=7
world: setup-test
	FARHAND_AT_LENGTH=1 FARHAND_SEED=$(SEED) FARHAND_TEST_DB=sqlite $(TEST) -n 2 tests/world

# The gate: each test that judges no measured time, once; on PostgreSQL where databases differ. A failure stops no part.
test: setup-test
	@$(MAKE) --keep-going --no-print-directory test-node test-sqlite test-postgres

test-node:
	$(PY) tools/run_node_tests.py

test-sqlite:
	FARHAND_TEST_DB=sqlite $(TEST) $(SIDE_BY_SIDE) -n 4 --timeout 900 -m "$(GATE) and not service"

test-postgres:
	FARHAND_TEST_DB=postgres $(TEST) $(SIDE_BY_SIDE) -n 4 --timeout 900 -m "$(GATE) and service" $(SERVICES)

# All tests, at length, on both databases: files side by side, then the tests that judge measured time one by one.
test-all: setup-all
	@$(MAKE) --keep-going --no-print-directory test-node all-sqlite all-postgres timed-sqlite timed-postgres

all-%:
	FARHAND_AT_LENGTH=1 FARHAND_TEST_DB=$* $(TEST) $(SIDE_BY_SIDE) -n 3 --timeout 3600 -m "not timed"

timed-%:
	FARHAND_AT_LENGTH=1 FARHAND_TEST_DB=$* $(TEST) --timeout 3600 -m timed

# LeRobot's own classes against simulated servos; the other targets skip this file unless the extra is installed.
test-lerobot: setup-test lerobot
	FARHAND_TEST_DB=sqlite $(TEST) tests/drivers/test_lerobot_driver.py

check: setup-test
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy .
	$(PY) tools/check_frontend.py
	.venv/bin/lint-imports
	PYTHONPATH=. $(PY) -m tests.outdated
	FARHAND_VAR=$$(mktemp -d) $(PY) manage.py makemigrations --check --dry-run
	FARHAND_VAR=$$(mktemp -d) FARHAND_PUBLIC=1 ALLOWED_HOSTS=robots.example.org EMAIL_URL=smtp://localhost:25 $(PY) manage.py check --deploy --fail-level WARNING

# make bench NAME=click_to_image
bench: setup-test
	@PYTHONPATH=. $(PY) -m benchmarks $(NAME)

# The promises at full numbers, or one of them: make proofs P=7; of one robot only: R=mercury
proofs: setup-test
	PYTHONPATH=. $(PY) -m tests.proofs $(P) $(R)

# Mutation tests: break the promises' code by one small change at a time; each must make its test fail.
mutants: setup-test
	PYTHONPATH=. $(PY) -m tests.mutants $(P)

# The table of security requirements, from the tests' marks.
asvs: setup-test
	PYTHONPATH=. $(PY) -m tests.asvs

# Simulated people drive and watch robots while faults are injected: make soak HOURS=1
soak: setup-test
	PYTHONPATH=. $(PY) -m tests.soak $(or $(HOURS),1)

# A wheel in dist/ that contains the built front end: pip install dist/farhand-*.whl && farhand demo
wheel: setup
	rm -rf dist
	.venv/bin/uv build --system-certs --wheel --out-dir dist

# The screenshots of README and docs, taken from a running portal.
shots: setup-test
	PYTHONPATH=. $(PY) -m tests.e2e.shots docs/images
	PYTHONPATH=. $(PY) -m tests.e2e.moments docs/images
	PYTHONPATH=. $(PY) -m tests.e2e.orientation_pictures
	PYTHONPATH=. $(PY) -m tests.e2e.page_shots docs/images/pages

lock:
	.venv/bin/uv pip compile -q --universal --python-version 3.11 --no-deps --generate-hashes --no-emit-index-url \
	  --no-header --no-annotate requirements/lerobot.in -o requirements/lerobot.lock
	.venv/bin/uv pip compile -q --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	  --no-header --no-annotate requirements/octoprint.in -o requirements/octoprint.lock
	for name in base test bench node uv fuzzy foxglove; do .venv/bin/uv pip compile -q --universal --python-version 3.11 \
	  --override requirements/overrides.txt --generate-hashes --no-emit-index-url --no-header --no-annotate requirements/$$name.in \
	  -o requirements/$$name.lock || exit 1; done

clean:
	rm -rf .venv var frontend/node_modules frontend/dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
