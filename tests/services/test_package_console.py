"""Whatever a package's `console.html` says, its robot's page has Stop, outside every element of the console."""

from html.parser import HTMLParser

import pytest
from django.template import engines

from robots.models import Robot
from tests.packaged import TURNTABLE, installed_from, with_console

pytestmark = pytest.mark.django_db
VOID = {"img", "input", "link", "meta", "br", "hr", "rect"}
OWN = (TURNTABLE / "turntable_robot/console/console.html").read_text()
NOTHING = '<div id="turntable-all"><p>All that it has.</p></div>'


class Page(HTMLParser):
    """The classes of the elements around each button of a command and each element with an id."""

    def __init__(self, text):
        super().__init__()
        self._open, self.stops, self.around = [], [], {}
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        told = dict(attrs)
        around = " ".join(classes for _, classes in self._open).split()
        if told.get("data-command") == "stop":
            self.stops.append(around)
        self.around[told.get("id")] = around
        if tag not in VOID:
            self._open.append((tag, told.get("class") or ""))

    def handle_endtag(self, tag):
        while self._open and self._open.pop()[0] != tag:
            pass


def forget():
    """Have templates read anew: the same name is another file now."""
    for loader in engines["django"].engine.template_loaders:
        loader.reset()


@pytest.fixture
def shown(robot, client, monkeypatch, tmp_path):
    """Return the robot's page with that text as its console."""

    def show(text):
        with installed_from(with_console(tmp_path / "package", text), monkeypatch):
            Robot.objects.update(driver="turntable", calibration={})
            forget()
            return Page(client.get("/robots/mercury/").text)

    yield show
    forget()


@pytest.mark.parametrize(
    "text", [OWN, NOTHING, "", '{% extends "consoles/frame.html" %}', "{% block body %}{% endblock %}"]
)
def test_no_console_can_leave_stop_out_or_own_it(shown, text):
    page = shown(text)
    assert len(page.stops) == 1
    (around,) = page.stops
    assert "part" not in around
    assert "stage-bar" in around
    assert {"why", "release", "checked", "keys", "screen", "picture", "age", "latency"} <= set(page.around)


def test_what_extends_nothing_is_the_body(shown):
    page = shown(NOTHING)
    assert page.around["turntable-all"][-1] == "part"
    assert "controls" not in page.around["turntable-all"]


def test_the_blocks_stand_in_their_places(shown):
    page = shown(OWN)
    assert page.around["turntable-goal"][-3:] == ["controls", "part", "turntable-ask"]
    assert page.around["turntable"][-1] == "part"
    assert "controls" not in page.around["turntable"]
