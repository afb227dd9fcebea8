"""The gallery of a robot whose only language is a further one of other robots: the tasks of the virtual reality arm."""

import pytest

from robots.kit.clock import SYSTEM
from robots.kit.description import programs_of
from robots.services import programs

pytestmark = [
    pytest.mark.service, pytest.mark.django_db, pytest.mark.parametrize("which", ["puma"], indirect=True),
]  # fmt: skip


def test_the_gallery_has_the_tasks_of_the_arms_package(robot):
    programs.load_gallery(robot, SYSTEM.now())
    programs.load_gallery(robot, SYSTEM.now())  # again after an upgrade
    own = {name for name, _ in programs_of("puma", "task")}
    assert "The figure of five bricks" in own
    for kind in ("task", ""):
        assert set(programs.visible(robot, None, kind).values_list("name", flat=True)) == own
