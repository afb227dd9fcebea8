import pytest


@pytest.hookimpl(tryfirst=True)  # before what is chosen by marks
def pytest_collection_modifyitems(items):
    """Mark the unit tests: they only compute."""
    for item in items:
        if item.nodeid.startswith("tests/unit/"):
            item.add_marker("computes")
