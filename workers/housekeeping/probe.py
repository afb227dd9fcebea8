"""Tests robots that no worker owns (connection, state, first picture), one at a time per process."""

import logging
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from django.conf import settings

from robots.grants import lease_of
from robots.kit import addresses
from robots.kit.clock import SYSTEM
from robots.kit.contract.capabilities import Stills
from robots.kit.contract.channels import finite, whole
from robots.kit.contract.errors import CameraFault, LineSilent, RobotError, why
from robots.kit.contract.find import open_session
from robots.kit.contract.session import RobotState, Session
from robots.kit.description import views
from robots.kit.installed import simulator_module
from robots.kit.vision.masks import masked, masks_of
from robots.models import Robot, frame_name
from robots.services import probes
from workers.door import Door, GuardedSession
from workers.media.source import DriverCamera, fitted, open_camera
from workers.media.steps import jpeg

log = logging.getLogger(__name__)
ASKED_AGAIN = 3  # times
FIRST_S = 5.0  # until a camera behind a driver shows its first picture
_slot = threading.Lock()


def all_that_wait(give_up: Callable[[], bool]) -> None:
    """Carry out every requested test; return at once if another thread is doing so."""
    while probes.waiting() and not give_up():
        if not _slot.acquire(blocking=False):
            return  # the thread that holds the lock looks once more after it has released it
        try:
            while not give_up() and (robot := probes.claim(SYSTEM.now())) is not None:
                _one(robot)
        finally:
            _slot.release()


def _one(robot: Robot) -> None:
    found: dict[str, Any] = {
        "connection": "The test failed; the log of the housekeeping worker says why.",
        "picture": "",
    }
    try:
        simulator = _start_simulator(robot)
        try:
            found = probe(robot)
        finally:
            if simulator is not None:
                simulator.terminate()
                simulator.wait(10)
    except Exception:
        log.exception("the test of %s failed", robot.slug)
    finally:
        probes.finish(robot, found, SYSTEM.now())


def _start_simulator(robot: Robot) -> "subprocess.Popen[bytes] | None":
    kind, _, name = robot.address.partition(":")
    if kind != "sim" or robot.enabled:
        return None
    described = robot.description()
    apart = bool(views(described)) and not described["camera"].get("by_driver")
    signs = [robot.rig_dir / sign for sign in ("tty", "camera")[: 1 + apart]]
    for sign in signs:
        sign.unlink(missing_ok=True)
    module = simulator_module(name)
    process = subprocess.Popen([sys.executable, "-m", module, "--dir", str(robot.rig_dir)])  # noqa: S603
    until = SYSTEM.awake() + 20
    while SYSTEM.awake() < until and not all(sign.exists() for sign in signs):
        SYSTEM.sleep(0.1)
    return process


def _answer(driver: Session) -> RobotState:
    """Connect; a silent robot is asked again over the same line: it may boot because that was opened."""
    for _ in range(ASKED_AGAIN):
        with suppress(LineSilent):
            return driver.connect()
    return driver.connect()


def probe(robot: Robot) -> dict[str, Any]:
    """Return what the robot and its first camera answered."""
    found: dict[str, Any] = {"connection": "", "picture": ""}
    lease = lease_of(robot)
    told = robot.driver_settings(lease.epoch if lease else 0)
    driver = GuardedSession(lambda: open_session(robot.driver, robot.wire_address, told))
    described, taken = robot.description(), None
    by_driver = bool(views(described)) and bool(described["camera"].get("by_driver"))
    try:
        addresses.check_robot_now(robot.address)
        state = _answer(driver)
        found["connection"] = "ok"
        values = {name: round(value, 4) for name, value in finite(state.values).items()}
        found["state"] = {"pose": [round(v, 4) for v in whole(state.pose)], "values": values, "ready": state.ready}
        taken = driver.picture(views(described)[0], FIRST_S) if by_driver else None
    except (RobotError, addresses.AddressError) as error:
        found["connection"] = str(error)
    finally:
        driver.close()
    if not views(described):
        return found | {"picture": "It has no camera."}
    stills = robot.spec().capability(Stills)
    door = Door(CameraFault, "The camera failed")
    try:
        view, colour = views(described)[0], bool(described["camera"].get("colour"))
        source = DriverCamera(lambda _view, _seconds: taken, view, colour) if by_driver else None
        with door.open(CameraFault):
            camera = source or open_camera(robot.camera_address(0), robot.rig_dir, view, colour)
            with closing(camera):
                picture = camera.grab(stills.exposure_s if stills else None)
            if masks := masks_of(robot.settings, 0):  # they count in the pixels of the description
                size = int(described["camera"]["width"]), int(described["camera"]["height"])
                picture = masked(fitted(picture, *size), masks)
        name = f"frames/{robot.slug}/probe-{frame_name()}.jpg"
        path = Path(settings.MEDIA_ROOT) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(jpeg(picture))
        found["picture"], found["file"] = "ok", name
    except CameraFault as error:
        found["picture"] = str(error)
    except OSError as error:
        found["picture"] = f"The picture could not be stored: {why(error)}."
    return found
