"""Robot packages that were written for version 0.1 import modules of the kit by their former names."""

import sys
import warnings
from importlib import import_module
from pathlib import Path

import pytest

from robots.kit import former

MODULES = {
    "robots.contract.spec": "robots.kit.contract.spec",
    "robots.contract.session": "robots.kit.contract.session",
    "robots.drivers.errors": "robots.kit.contract.errors",
    "robots.drivers.lerobot_spec": "robots.kit.drivers.lerobot_spec",
    "robots.motion.zones": "robots.kit.arms.zones",
    "robots.autonomy.fuzzy": "robots.kit.rovers.fuzzy",
    "robots.autonomy.ratslam.angles": "robots.kit.slam.angles",
    "robots.clock": "robots.kit.clock",
}


@pytest.fixture(autouse=True)
def not_imported_before(monkeypatch):
    for name in [n for n in sys.modules if former.present_name(n)]:
        monkeypatch.delitem(sys.modules, name)


def imported(name):
    """Return the module of that name, and the warnings of its import."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return import_module(name), [str(one.message) for one in said]


@pytest.mark.parametrize("name", MODULES)
def test_a_former_name_is_the_same_module_and_says_so(name):
    module, said = imported(name)
    assert module is import_module(MODULES[name])
    assert f"{name} is {MODULES[name]} now; the former name goes with 1.0." in said


def test_every_former_name_leads_to_a_module():
    for name, present in former.PLACES.items():
        assert imported(name)[0] is import_module(present)


def test_a_folder_that_an_older_version_left_behind_hides_nothing(tmp_path, monkeypatch):
    (tmp_path / "contract").mkdir()
    monkeypatch.setattr(sys.modules["robots"], "__path__", [*sys.modules["robots"].__path__, str(tmp_path)])
    assert imported("robots.contract.errors")[0] is import_module("robots.kit.contract.errors")


def test_a_name_that_was_never_there_is_no_former_name():
    assert former.present_name("robots.models") is None
    assert former.present_name("robots.contracts") is None
    with pytest.raises(ModuleNotFoundError, match="robots.kit.contract.nothing"):
        imported("robots.contract.nothing")


def test_the_docs_name_their_end():
    page = (Path(__file__).resolve().parents[2] / "docs/how-to/add-a-robot.md").read_text()
    assert "robots/kit/former.py" in page and "version 1.0" in page
