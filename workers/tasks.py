"""The few Celery tasks of a robot: the bell, the test of a connection, the broom."""

import shutil
import subprocess
import sys
import time
from contextlib import closing
from datetime import timedelta
from pathlib import Path
from typing import Any

from celery import shared_task
from django.conf import settings

from robots import bus
from robots.clock import SYSTEM
from robots.description import simulator_module, views
from robots.drivers.contract import make_driver
from robots.drivers.errors import CameraFault, RobotError
from robots.messages import Changed
from robots.models import Frame, Lease, Robot, frame_name
from workers import bootstep
from workers.cameras import open_camera
from workers.pictures import jpeg


@shared_task(name="robots.look", ignore_result=True, max_retries=0)
def look() -> None:
    """Answer the bell: the owner looks at its command rows."""
    if bootstep.runtime is not None:
        bootstep.runtime.look()


@shared_task(name="robots.probe", ignore_result=True, max_retries=0)
def probe(slug: str) -> None:
    """Test a robot that no worker owns: connection, state, first picture."""
    robot = Robot.objects.get(slug=slug)
    simulator = _start_simulator(robot)
    try:
        found = _probe(robot)
    finally:
        if simulator is not None:
            simulator.terminate()
            simulator.wait(10)
    found["at"] = SYSTEM.now().isoformat()
    Robot.objects.filter(pk=robot.pk).update(probe=found)
    bus.publish(slug, Changed("robot"))


def _start_simulator(robot: Robot) -> "subprocess.Popen[bytes] | None":
    kind, _, name = robot.address.partition(":")
    if kind != "sim" or robot.enabled:
        return None
    signs = [robot.rig_dir / sign for sign in ("tty", "camera")[: 1 + bool(views(robot.description()))]]
    for sign in signs:
        sign.unlink(missing_ok=True)
    module = simulator_module(name)
    process = subprocess.Popen([sys.executable, "-m", module, "--dir", str(robot.rig_dir)])  # noqa: S603
    until = time.monotonic() + 20
    while time.monotonic() < until and not all(sign.exists() for sign in signs):
        time.sleep(0.1)
    return process


def _probe(robot: Robot) -> dict[str, Any]:
    found: dict[str, Any] = {"connection": "", "picture": ""}
    lease = Lease.objects.filter(robot=robot).first()
    driver = make_driver(robot.driver, robot.wire_address, robot.driver_settings(lease.epoch if lease else 0))
    try:
        state = driver.connect()
        found["connection"] = "ok"
        found["state"] = {"pose": [round(v, 4) for v in state.pose], "ready": state.ready}
    except RobotError as error:
        found["connection"] = str(error)
    finally:
        driver.close()
    described = robot.description()
    if not views(described):
        return found | {"picture": "It has no camera."}
    try:
        view, colour = views(described)[0], bool(described["camera"].get("colour"))
        with closing(open_camera(robot.camera_address(0), robot.rig_dir, view, colour)) as camera:
            picture = camera.grab(1 / 150)
        name = f"frames/{robot.slug}/probe-{frame_name()}.jpg"
        path = Path(settings.MEDIA_ROOT) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(jpeg(picture))
        found["picture"], found["file"] = "ok", name
    except (CameraFault, OSError) as error:
        found["picture"] = str(error)
    return found


@shared_task(name="robots.clean", ignore_result=True, max_retries=0)
def clean() -> int:
    """Remove pictures past their time that nothing refers to; return how many."""
    before = SYSTEM.now() - timedelta(days=settings.FRAME_KEEP_DAYS)
    removed = 0
    for frame in Frame.objects.filter(taken_at__lt=before, kept=False).iterator():
        (Path(settings.MEDIA_ROOT) / frame.file).unlink(missing_ok=True)
        frame.delete()
        removed += 1
    for folder in Path(settings.MEDIA_ROOT).glob("frames/*/*"):
        if folder.is_dir() and not any(folder.iterdir()):
            shutil.rmtree(folder, ignore_errors=True)
    return removed
