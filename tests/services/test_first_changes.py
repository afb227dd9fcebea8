"""The changes that docs/how-to/first-changes.md shows are all that is needed, and touch as few files as it says."""

import re
import shutil
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location

import pytest
from django.contrib import admin

from robots.kit.clock import SYSTEM
from robots.kit.contract.find import open_session, spec_of
from robots.models import Robot
from tests.environment import ROOT
from tests.packaged import installed_from

PAGE = (ROOT / "docs/how-to/first-changes.md").read_text()
COMMAND, VALUE, WEB = (part for part in re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:])
MOST = {COMMAND: 4, VALUE: 3, WEB: 4}


def changes(part):
    """Return (file, lines before, lines after) of each change that a part of the page shows."""
    found = re.findall(r"```diff\n--- (\S+)\n(.*?)```", part, re.DOTALL)
    return [
        (name, *("".join(line[1:] for line in text.splitlines(True) if line[0] in marks) for marks in (" -", " +")))
        for name, text in found
    ]


def apply(part, into):
    """Make the changes in copies of the files in another folder."""
    for name, before, after in changes(part):
        file = into / name
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists():
            file.write_text((ROOT / name).read_text() if before else "")
        text = file.read_text()
        assert not before or text.count(before) == 1, f"{name} has other lines by now: {before}"
        file.write_text(text.replace(before, after) if before else after)


@pytest.fixture
def turntable(tmp_path, monkeypatch):
    folder = "tests/packages/turntable"
    shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for part in (COMMAND, VALUE):
        apply(part, tmp_path)
    with installed_from(tmp_path / folder, monkeypatch):
        running = subprocess.Popen([sys.executable, "-m", "turntable_robot.simulator", "--dir", str(tmp_path)])
        tty = tmp_path / "tty"
        while not tty.exists() and running.poll() is None:
            SYSTEM.sleep(0.02)
        session = open_session("turntable", str(tty), {})
        session.connect()
        yield session
        session.close()
        running.kill()
        running.wait()


def test_each_change_touches_as_few_files_as_is_said():
    for part, most in MOST.items():
        files = {name for name, *_ in changes(part)}
        assert 0 < len(files) <= most, part.splitlines()[0]


def test_a_new_command_and_a_new_value_work(turntable):
    assert spec_of("turntable").command("wave") is not None
    outcome = turntable.execute("wave", {"times": 2}, lambda: None, lambda stage: None)
    assert outcome.state.joints[0] == pytest.approx(-0.1)
    assert turntable.state().values["load"] == 0.1


@pytest.mark.django_db
def test_a_new_page_is_there_with_its_link(tmp_path, settings, monkeypatch, client):
    apply(WEB, tmp_path)
    for held, name in [(page, "add_view") for page in admin.site._registry.values()] + [(admin.site, "login")]:
        monkeypatch.setattr(held, name, getattr(held, name))  # as it is: the addresses wrap it when they are read
    for name in ("portal.web.pages.fleet", "portal.urls"):
        place = spec_from_file_location(name, tmp_path / f"{name.replace('.', '/')}.py")
        module = module_from_spec(place)
        monkeypatch.setitem(sys.modules, name, module)
        if "." in name.removeprefix("portal."):
            monkeypatch.setattr("portal.web.pages.fleet", module, raising=False)
        place.loader.exec_module(module)
    settings.TEMPLATES = [{**settings.TEMPLATES[0], "DIRS": [tmp_path / "templates", *settings.TEMPLATES[0]["DIRS"]]}]
    settings.ROOT_URLCONF = sys.modules["portal.urls"]
    Robot.objects.create(
        slug="one", name="One", tagline="It turns.", driver="mercury", address="sim:mercury", enabled=True
    )
    page = client.get("/fleet/")
    assert page.status_code == 200
    assert "One (simulated)</a>: It turns." in page.content.decode()
    assert '<a href="/fleet/">' in client.get("/status/").content.decode()
