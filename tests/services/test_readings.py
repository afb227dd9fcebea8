"""The robot's last values, as staff read them and a picture stores them: those that its spec declares, with units."""

from types import SimpleNamespace

import numpy as np
import pytest
from django.template.loader import render_to_string

from robots.kit.clock import SYSTEM
from robots.kit.contract.session import RobotState
from robots.models import Frame, Lease
from tests.services.owner import made_owner
from workers.media.pictures import StillPicture

pytestmark = [pytest.mark.service, pytest.mark.django_db(transaction=True)]
NAN = float("nan")


def status(client, robot, people):
    client.force_login(people["kim"])
    return client.get(f"/admin/robots/robot/{robot.pk}/status/").content.decode()


def told(owner, **what):
    owner.owned.remember(RobotState(0.0, what.pop("joints", ()), what.pop("pose", ()), False, True, **what))


@pytest.mark.parametrize("which", ["mercury"], indirect=True)
def test_an_arms_pose_is_shown_by_the_coordinates_that_it_declares(client, robot, people):
    told(made_owner(robot, people), joints=(0.0,) * 4, pose=(0.1, 0.42, 0.075, 0.5))
    page = status(client, robot, people)
    for name, value in (("x", "0.1 m"), ("z", "0.075 m"), ("theta", "0.5 rad")):
        assert f"{name} {value}" in page


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("which", ["turntable"], indirect=True)
def test_a_robot_without_a_pose_shows_none(client, robot, people):
    told(made_owner(robot, people), joints=(0.5,), pose=(1.0, 2.0), values={"warmth": 21.5, "undeclared": 1.0})
    page = status(client, robot, people)
    assert "<dd>warmth 21.5 °C (" in page
    assert "undeclared" not in page


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("which", ["turntable"], indirect=True)
def test_a_number_that_is_none_is_kept_nowhere(robot, people):
    told(made_owner(robot, people), joints=(NAN,), pose=(NAN, 1.0), values={"warmth": NAN})
    kept = Lease.objects.get(robot=robot).state
    assert (kept["joints"], kept["pose"], kept["values"]) == ([], [], {})


@pytest.mark.parametrize("which", ["pa10"], indirect=True)
def test_a_picture_keeps_the_values_of_its_moment(robot, people):
    owner = made_owner(robot, people)
    state = RobotState(0.0, (0.1, 0.2), (), False, True, values={"charge": 80.0, "heat": NAN})
    verdict = SimpleNamespace(stable=True, reason="", difference=0.0, tries=1)
    fields = owner.pictures._stored(StillPicture(np.zeros((4, 6), np.uint8), b"jpeg", 1, SYSTEM.now(), verdict), state)
    kept = Frame.objects.get(pk=Frame.objects.create(robot=robot, **fields).pk)
    assert (kept.joints, kept.pose, kept.values) == ([0.1, 0.2], [], {"charge": 80.0})


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("which", ["turntable", "mercury"], indirect=True)
def test_below_a_picture_stand_the_channels_that_its_robot_declares(robot):
    frame = Frame(robot=robot, taken_at=SYSTEM.now(), file="frames/a.jpg", values={"warmth": 21.5, "undeclared": 1.0})
    shown = render_to_string("operatorlog/frame.html", {"frame": frame, "words": "Picture"})
    assert ("warmth 21.5&nbsp;°C" in shown) is (robot.driver == "turntable")
    assert "undeclared" not in shown
    assert render_to_string("operatorlog/frame.html", {"frame": Frame(robot=robot, taken_at=SYSTEM.now())}).startswith(
        "<img"
    )
