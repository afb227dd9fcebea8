"""Settings that a robot's spec declares: shown, checked and kept in the admin; nothing where none is declared."""

import json
from importlib import import_module

import pytest
from django.db import connection
from django.db.migrations.executor import MigrationExecutor

from portal.web.pages.views import console_facts
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Calibration, ResultRow
from robots.kit.contract.find import spec_of
from robots.models import Robot
from workers.media.pictures import Pictures

pytestmark = [pytest.mark.service, pytest.mark.django_db]
VASE = {"name": "the vase", "low": [0.4, 0.1, 0.0], "high": [0.6, 0.3, 0.3]}
OF_STILLS = {"setting_still_threshold", "setting_still_exposure_s"}
NUMBER = "Write a number from 0.02 to 0.6 m/s, or leave it empty."


def address(robot):
    return f"/admin/robots/robot/{robot.pk}/change/"


def form(client, robot):
    return client.get(address(robot)).context["adminform"].form


def sent(robot, **more):
    about = {name: getattr(robot, name) for name in ("name", "slug", "driver", "address", "camera", "tagline", "story")}
    return about | {"records": "off"} | {f"setting_{name}": value for name, value in more.items()}


@pytest.fixture
def admin(client, admin_user):
    client.force_login(admin_user)
    return client


@pytest.mark.parametrize(
    "driver, names",
    [
        ("mercury", {"setting_speed", *OF_STILLS}), ("pa10", {"setting_boxes", "setting_tidy_s", *OF_STILLS}), ("irat", set()),
        ("so101", set()), ("gone", set()),
    ],
)  # fmt: skip
def test_the_admin_shows_what_the_spec_declares(robot, admin, driver, names):
    Robot.objects.update(driver=driver)
    page = admin.get(address(robot))
    assert {name for name in page.context["adminform"].form.fields if name.startswith("setting_")} == names
    assert ("Forbidden boxes" in page.text) == (driver == "pa10")
    assert ("Speed (m/s)" in page.text) == (driver == "mercury")
    assert ("Stability threshold (grey levels)" in page.text) == bool(names)


def test_a_package_of_its_own_has_no_settings_that_it_does_not_declare(robot, admin, installed):
    Robot.objects.update(driver="turntable")
    assert not [name for name in form(admin, robot).fields if name.startswith("setting_")]


def test_what_is_written_is_kept_shown_again_and_told_to_the_driver(robot, admin):
    assert admin.post(address(robot), sent(robot, speed="0.1", still_threshold="")).status_code == 302
    robot.refresh_from_db()
    assert robot.settings == {"speed": 0.1}
    assert robot.driver_settings()["speed"] == 0.1
    assert form(admin, robot)["setting_speed"].value() == 0.1
    admin.post(address(robot), sent(robot, speed=""))
    robot.refresh_from_db()
    assert robot.settings == {}
    assert "speed" not in robot.driver_settings()


@pytest.mark.parametrize("value", ["0", "-1", "nan", "1e999", "0.61", "fast", "9" * 400])
def test_a_number_out_of_its_range_is_refused_in_words_and_nothing_is_lost(robot, admin, value):
    Robot.objects.update(settings={"speed": 0.3})
    answer = admin.post(address(robot), sent(robot, speed=value))
    assert NUMBER in answer.text
    assert answer.context["adminform"].form["setting_speed"].value() == value
    robot.refresh_from_db()
    assert robot.settings == {"speed": 0.3}


def test_stills_are_bounded_by_the_range_of_their_exposure(robot, admin):
    answer = admin.post(address(robot), sent(robot, still_exposure_s="0.5", still_threshold="-3"))
    assert set(answer.context["adminform"].form.errors) == OF_STILLS
    admin.post(address(robot), sent(robot, still_exposure_s="0.01", still_threshold="2"))
    robot.refresh_from_db()
    assert not {"still_exposure_s", "still_threshold"} & set(robot.driver_settings()), "the driver takes no pictures"
    eyes = Pictures(robot, SYSTEM, None)
    assert (eyes._stills.exposure_s, eyes._stills.threshold) == (0.01, 2.0)
    robot.settings = {"still_exposure_s": 9.0}
    eyes.configure(robot)
    assert eyes._stills.exposure_s == eyes._stills.exposure_range_s[1]


def test_a_list_is_tidied_by_the_robots_own_check_and_told_to_its_console(robot, admin):
    Robot.objects.update(driver="pa10", address="sim:pa10")
    robot.refresh_from_db()
    turned = VASE | {"low": VASE["high"], "high": VASE["low"]}
    admin.post(address(robot), sent(robot, boxes=json.dumps([turned])))
    robot.refresh_from_db()
    assert robot.settings == {"boxes": [VASE]}
    assert console_facts(robot, None)["set"] == {"boxes": [VASE]}
    assert json.loads(form(admin, robot)["setting_boxes"].value()) == [VASE]
    answer = admin.post(address(robot), sent(robot, boxes='[{"name": ""}]'))
    assert "Box 1 needs a name" in answer.text


def test_settings_wait_for_the_return_of_their_driver(robot, admin):
    Robot.objects.update(settings={"speed": 0.3, "boxes": "of another robot"})
    admin.post(address(robot), sent(robot, speed="0.2") | {"driver": "pa10", "address": "sim:pa10"})
    robot.refresh_from_db()
    assert (robot.driver, robot.settings) == ("pa10", {"speed": 0.2}), "what the arm would refuse is gone"
    assert "speed" not in robot.driver_settings()


def test_who_may_only_look_sees_the_settings(robot, client, django_user_model):
    from django.contrib.auth.models import Permission

    Robot.objects.update(settings={"speed": 0.3})
    viewer = django_user_model.objects.create_user("vera", "vera@example.org", "correct horse 42", is_staff=True)
    viewer.user_permissions.add(Permission.objects.get(codename="view_robot"))
    client.force_login(viewer)
    page = client.get(address(robot))
    assert "Speed: 0.3 m/s" in page.text
    assert "setting_speed" not in page.text


def test_the_result_of_a_calibration_is_shown_by_the_rows_that_are_declared(robot, admin):
    page = admin.get(address(robot)).text
    assert "residual up: 0.2 mm; moves up: 6; residual down: 0.2 mm; moves down: 6" in page
    Robot.objects.update(calibration={"up": {"other": 1}})
    page = admin.get(address(robot)).text
    assert "None" not in page.split("Calibration</dt>")[1].split("</dd>")[0]
    declared = Calibration("m:f", rows=(ResultRow("offset", ("zero", 0)), ResultRow("scale", ("scale",), "%")))
    assert declared.result_rows({"zero": [1], "scale": 3.5}) == (("scale", 3.5, "%"),)


@pytest.mark.django_db(transaction=True)
def test_an_update_keeps_what_staff_have_set_and_a_step_back_too():
    before, between = [("robots", "0017_microphone")], [("robots", "0018_settings")]
    newest = MigrationExecutor(connection).loader.graph.leaf_nodes()
    try:
        MigrationExecutor(connection).migrate(before)
        old = MigrationExecutor(connection).loader.project_state(before).apps.get_model("robots", "Robot")
        old.objects.create(
            slug="a", name="A", address="sim:mercury", speed=0.2, delivery_exposure_s=0.01, stability_threshold=2.0
        )
        old.objects.create(slug="b", name="B", address="sim:pa10", boxes=[VASE])
        old.objects.create(slug="c", name="C", address="sim:irat")
        MigrationExecutor(connection).migrate(newest)
        kept = dict(Robot.objects.values_list("slug", "settings"))
        assert kept == {
            "a": {"speed": 0.2, "still_exposure_s": 0.01, "still_threshold": 2.0}, "b": {"boxes": [VASE]}, "c": {},
        }  # fmt: skip
        MigrationExecutor(connection).migrate(before)
        names = "slug", "speed", "delivery_exposure_s", "stability_threshold", "boxes"
        assert list(old.objects.order_by("slug").values_list(*names)) == [
            ("a", 0.2, 0.01, 2.0, []), ("b", None, None, None, [VASE]), ("c", None, None, None, []),
        ]  # fmt: skip
    finally:
        MigrationExecutor(connection).migrate(newest)
    assert between[0] in MigrationExecutor(connection).loader.applied_migrations
    assert import_module("robots.migrations.0018_settings").moved({"boxes": [], "speed": None}) == {}


def test_every_declared_setting_says_what_it_is():
    for driver in ("mercury", "pa10"):
        for setting in spec_of(driver).settings():
            assert setting.label
            assert setting.unit or setting.kind == "list"
