"""The wheel's metadata names the same packages as a clone runs, and one version."""

import json
import tomllib
from configparser import ConfigParser

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.environment import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
TURNTABLE = ROOT / "tests" / "packages" / "turntable"


def pins(name):
    lines = (ROOT / "requirements" / name).read_text().splitlines()
    return [Requirement(line) for line in lines if line.strip() and not line.startswith(("-", "#"))]


def test_a_wheel_asks_for_the_packages_that_a_clone_runs_in_ranges_that_hold_their_versions():
    extra = PROJECT["optional-dependencies"]["postgres"]
    asked = {canonicalize_name(r.name): r for r in map(Requirement, PROJECT["dependencies"] + extra)}
    ours = {canonicalize_name(r.name): r for r in pins("base.in")}
    assert asked.keys() == ours.keys()
    for name, pin in ours.items():
        for version in (s.version for s in pin.specifier):
            assert asked[name].specifier.contains(version), f"{name} {version} is outside {asked[name].specifier}"


def test_the_extra_for_lerobot_is_the_version_that_is_tested():
    asked = {canonicalize_name(r.name): r for r in map(Requirement, PROJECT["optional-dependencies"]["lerobot"])}
    tested = {canonicalize_name(r.name): r for r in pins("lerobot.in")}
    assert asked["lerobot"].specifier == tested["lerobot"].specifier


def test_the_version_stands_in_one_place():
    assert "version" in PROJECT
    assert "version" not in json.loads((ROOT / "frontend" / "package.json").read_text())


@pytest.mark.parametrize("group", ["farhand.drivers", "farhand.simulators"])
def test_the_installed_package_of_the_tests_is_the_one_that_its_project_builds(group):
    """The tests put the package on the path as it lies there, with the metadata that pip would write."""
    built = tomllib.loads((TURNTABLE / "pyproject.toml").read_text())["project"]
    kept = ConfigParser()
    kept.read(TURNTABLE / "turntable_robot-0.1.dist-info" / "entry_points.txt")
    assert dict(kept[group]) == built["entry-points"][group]
    assert built["dependencies"] == ["farhand"]
