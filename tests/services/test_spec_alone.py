"""The web process asks a robot's spec alone: no driver is loaded for a click, a socket, a page or a preview."""

import subprocess
import sys
from datetime import timedelta

import pytest

from robots import services
from robots.kit.clock import SYSTEM
from robots.kit.contract.errors import BadRequest
from robots.kit.contract.find import function, open_session
from robots.models import Lease, Robot
from robots.states import Cycle, GrantKind
from tests.rig import PYTHON, ROOT

DRIVERS = ("robots.kit.drivers.mercury.driver", "robots.kit.drivers.pa10.driver", "robots.kit.drivers.lerobot")
CLICKS = {"mercury": ("move", {"x": 0.0, "y": 0.4}), "pa10": ("ready", {})}


@pytest.fixture
def unloadable(monkeypatch):
    """Make each driver's module one that cannot be imported."""
    function.cache_clear()  # another test may have loaded them
    for name in DRIVERS:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError):
        open_session("pa10", "", {})


@pytest.mark.django_db
@pytest.mark.parametrize("which", ["mercury", "pa10"], indirect=True)
def test_a_command_and_a_page_need_no_driver(unloadable, robot, people, client):
    now = SYSTEM.now()
    Robot.objects.update(cycle=Cycle.OPERATING)
    Lease.objects.update_or_create(robot=robot, defaults={"epoch": 1, "expires_at": now + timedelta(seconds=60)})
    services.start_grant(robot, GrantKind.TURN, now, people["ada"], now + timedelta(seconds=60))
    kind, args = CLICKS[robot.driver]
    assert services.issue(robot.slug, people["ada"], kind, args, 1, now).created
    with pytest.raises(BadRequest, match="no command called fly"):
        services.issue(robot.slug, people["ada"], "fly", {}, 2, now)
    assert client.get(f"/robots/{robot.slug}/").status_code == 200


@pytest.mark.django_db
@pytest.mark.parametrize("which", ["mercury", "pa10"], indirect=True)
def test_a_socket_needs_no_driver(unloadable, robot):
    from portal.live.robot_socket import RobotSocket

    socket = RobotSocket()
    socket.slug, socket.scope = robot.slug, {}
    _, held, *_ = socket.look()
    assert held == {"mercury": {"jog"}, "pa10": {"jog_joints", "jog_tool", "follow"}}[robot.driver]


SPECS = """
import sys
from robots.kit.contract.find import spec_of
for name in ("mercury", "pa10", "puma", "so101", "irat"):
    print(spec_of(name).name)
heavy = [m for m in sys.modules if m.split(".")[0] in ("django", "serial", "lerobot", "cv2", "redis")]
drivers = [m for m in sys.modules if m.endswith((".driver", ".line")) or m == "robots.kit.drivers.lerobot"]
assert not heavy + drivers, heavy + drivers
"""


def test_a_spec_is_read_without_driver_wire_or_django():
    done = subprocess.run([PYTHON, "-c", SPECS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout.splitlines() == ["Mercury", "Museum arm", "Virtual reality arm", "SO-101", "iRat"]
