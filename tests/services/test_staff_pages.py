"""Pages of staff: drivers are chosen, queues say who drives and waits, times have seconds, fields their units."""

import re

import pytest
from django.contrib import admin
from django.contrib.auth.models import Permission

from accounts.models import User
from queueing import services as queue
from queueing.models import Queue, Turn
from robots.admin.forms import RobotForm
from robots.kit.clock import SYSTEM
from robots.kit.installed import drivers
from robots.models import Robot
from robots.services import lockout
from tests.services.browsers import signed_in
from tests.services.turns import drive

pytestmark = [pytest.mark.service, pytest.mark.django_db, pytest.mark.usefixtures("owned")]
UNITS = ("_s", "_min", "_mb", "_days", "_px")


def with_rights(name, *codes):
    made = User.objects.create_user(name, f"{name}@example.org", "correct horse 42", is_staff=True)
    made.user_permissions.set(Permission.objects.filter(codename__in=codes))
    return User.objects.get(pk=made.pk)


def shown(user, address):
    return signed_in(user).get(address).content.decode()


def form_of(robot, **changed):
    form = RobotForm(instance=robot)
    data = {name: value for name, value in form.initial.items() if value is not None and name in form.fields}
    return RobotForm({**data, **changed}, instance=robot)


def test_the_driver_is_chosen_among_those_that_are_installed(robot):
    offered = [name for name, _ in RobotForm().fields["driver"].choices]
    assert offered == drivers()
    assert {"mercury", "irat"} <= set(offered)
    assert not {"__pycache__", "console", ""} & set(offered)
    bad = form_of(robot, driver="nowhere")
    assert bad.errors == {"driver": ["There is no driver named nowhere here; install its package and restart."]}


def test_a_robot_whose_package_is_gone_keeps_its_driver_and_can_be_renamed(robot):
    Robot.objects.update(driver="gone", address="serial:/dev/ttyUSB0")
    robot = Robot.objects.get()
    assert ("gone", "gone (not installed)") in RobotForm(instance=robot).fields["driver"].choices
    form = form_of(robot, name="Old friend")
    assert form.errors == {}
    form.save()
    robot.refresh_from_db()
    assert (robot.name, robot.driver) == ("Old friend", "gone")
    assert ("gone", "gone (not installed)") not in RobotForm().fields["driver"].choices


def test_a_queue_says_who_drives_and_who_waits_in_order(robot, people, django_user_model):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    drive(robot, people["ada"], SYSTEM.now())
    queue.join(robot, people["bob"], SYSTEM.now())
    one = Queue.objects.get()
    for address in ("/admin/queueing/queue/", f"/admin/queueing/queue/{one.pk}/change/"):
        text = shown(root, address)
        assert re.search(r"Mercury: ada until \d\d:\d\d:\d\d", text)
        assert "bob" in text
    assert re.search(r"bob</a>: waiting; in the queue since \d\d:\d\d:\d\d, last seen \d\d:\d\d:\d\d", text)
    assert "1: bob" in shown(root, "/admin/queueing/queue/")


def test_names_of_people_who_wait_are_for_staff_who_may_see_places(robot, people):
    queue.join(robot, people["bob"], SYSTEM.now())
    one = with_rights("vic", "view_queue", "view_queuerobot")
    for address in ("/admin/queueing/queue/", f"/admin/queueing/queue/{Queue.objects.get().pk}/change/"):
        assert "bob" not in shown(one, address)


def test_a_queue_is_paused_in_the_list(robot, people, admin_client):
    line = queue.queue_of(robot)
    rows = {"form-TOTAL_FORMS": 1, "form-INITIAL_FORMS": 1, "form-0-id": line.pk, "_save": "1"}
    for paused in (True, False):
        admin_client.post("/admin/queueing/queue/", rows | ({"form-0-paused": "on"} if paused else {}))
        line.refresh_from_db()
        assert line.paused == paused
        assert ("(paused)" in admin_client.get("/admin/").text) == paused


def test_a_maintenance_turn_is_said_to_drive(robot, people):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    lockout.lock_out(robot, people["kim"], "a new belt")
    lockout.start_maintenance(robot, people["kim"])
    assert "Mercury: Staff, kim" in shown(root, "/admin/queueing/queue/")
    assert "/do/end_maintenance/" in shown(root, f"/admin/robots/robot/{robot.pk}/change/")


def test_a_stop_is_told_only_where_one_is_latched(robot, people):
    assert 'farhand-bad">Stopped' not in shown(people["kim"], "/admin/robots/robot/")
    Robot.objects.update(stop_latched=True)
    assert 'farhand-bad">Stopped' in shown(people["kim"], "/admin/robots/robot/")


def test_times_of_lists_have_seconds(robot, people):
    root = User.objects.create_superuser("root", "root@example.org", "correct horse 42")
    turn = drive(robot, people["ada"], SYSTEM.now())
    assert f"{turn.started_at:%-d %b %Y, %H:%M:%S}" in shown(root, "/admin/queueing/turn/")


def test_each_field_with_a_unit_names_it_in_its_label(robot):
    missing = [
        f"{model.__name__}.{field.name}"
        for model in admin.site._registry
        for field in model._meta.concrete_fields
        if field.name.endswith(UNITS) and "(" not in str(field.verbose_name)
    ]
    assert missing == []
    assert str(Turn._meta.get_field("charged_s").verbose_name) == "charged (s)"


def test_no_two_pages_of_the_menu_have_one_name(admin_client):
    text = admin_client.get("/admin/").content.decode()
    names = re.findall(r'<th scope="row".*?<a [^>]*>([^<]+)</a>', text[text.index('aria-label="Menu"') :], re.DOTALL)
    assert len(names) == len(set(names)) > 15
    assert {"Pictures", "Places in queues", "People"} <= set(names)
