# Farhand. `make run` and `make test` set up what they need by themselves.
PYTHON ?= python3
PORT ?= 8000
PY = .venv/bin/python
TEST = PYTHONPATH=. $(PY) -m pytest

.PHONY: run setup setup-test test test-all check bench shots lock clean

run: setup
	@exec $(PY) manage.py demo --port $(PORT)

setup:
	@$(PYTHON) tools/setup.py run

setup-test:
	@$(PYTHON) tools/setup.py test

# Everything on SQLite, then services and a marked tenth of the rest on PostgreSQL.
test: setup-test
	$(PY) tools/run_node_tests.py
	FARHAND_TEST_DB=sqlite $(TEST) tests
	FARHAND_TEST_DB=postgres $(TEST) tests -m "service or tenth"

# Everything on both.
test-all: setup-test
	$(PY) tools/run_node_tests.py
	FARHAND_TEST_DB=sqlite $(TEST) tests
	FARHAND_TEST_DB=postgres $(TEST) tests

check: setup-test
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy .
	.venv/bin/lint-imports
	FARHAND_VAR=$$(mktemp -d) $(PY) manage.py makemigrations --check --dry-run
	FARHAND_VAR=$$(mktemp -d) FARHAND_PUBLIC=1 ALLOWED_HOSTS=robots.example.org $(PY) manage.py check --deploy --fail-level WARNING

# make bench NAME=click_to_image
bench: setup-test
	@PYTHONPATH=. $(PY) -m benchmarks $(NAME)

# The screenshots of README and docs, taken from a running portal.
shots: setup-test
	PYTHONPATH=. $(PY) -m tests.e2e.shots docs/images

lock:
	for name in base test node uv; do .venv/bin/uv pip compile -q --universal --python-version 3.11 \
	  --generate-hashes --no-emit-index-url --no-header --no-annotate requirements/$$name.in \
	  -o requirements/$$name.lock || exit 1; done

clean:
	rm -rf .venv var frontend/node_modules frontend/dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
