"""Between two turns: home, verify by state and camera, only then ready. Fails closed."""

import logging
from datetime import timedelta
from typing import TYPE_CHECKING

from robots.drivers.contract import Permit, RobotState
from robots.drivers.errors import CameraFault, HardwareFault, NotPermitted, RobotError, StaleEpoch
from robots.grants import end_grant, open_grant, start_grant
from robots.models import Grant
from robots.states import Cycle, GrantKind
from robots.vision.calibration import NotCalibrated
from workers import ledger
from workers.calibrate import calibrate

if TYPE_CHECKING:
    from workers.runtime import Runtime

log = logging.getLogger(__name__)
LIMIT_S = 180


def hand_over(runtime: "Runtime") -> None:
    """Put the robot in order under a grant of its own; ready, or a fault with a reason."""
    robot = runtime.robot
    grant = open_grant(robot)
    if grant is not None and grant.kind == GrantKind.HANDOVER:  # an earlier owner's, interrupted
        end_grant(grant, "owner restarted", runtime.now())
        grant = None
    if grant is not None:
        return
    now = runtime.now()
    try:
        grant = start_grant(robot, GrantKind.HANDOVER, now, until=now + timedelta(seconds=LIMIT_S))
    except NotPermitted:
        return
    try:
        _put_in_order(runtime, grant)
    except StaleEpoch:  # nothing is wrong with the robot: it is done once more when it is ours again
        end_grant(grant, "the owner's lease ran out", runtime.now())
    except (RobotError, NotCalibrated) as error:
        end_grant(grant, "could not be verified", runtime.now())
        ledger.incident(robot, getattr(error, "code", "calibration"), str(error), runtime.now(), remedy="Not offered.")
        runtime.set_cycle(Cycle.FAULT, f"It could not be put in order: {error}", Cycle.HANDOVER)
        runtime.reach.later(10.0)
    else:
        end_grant(grant, "in order", runtime.now())
        runtime.set_cycle(Cycle.READY, "", Cycle.HANDOVER)


def _put_in_order(runtime: "Runtime", grant: Grant) -> None:
    runtime.gate.open_for(grant, runtime.now())
    driver, permit = runtime.driver, runtime.gate.bound(runtime.lease.epoch)
    runtime.pictures.still_id = 0
    state = driver.state()
    if runtime.latch.latched:
        # A stop outlives the turn: nothing moves, and the next operator must look and
        # release it. At rest and in the picture is all that is verified.
        if state.moving:
            raise HardwareFault("The robot moves although it is stopped.")
    else:
        if not state.ready:
            state = driver.recover(permit)
        try:
            state = _home(runtime, permit) or state
        except HardwareFault as error:
            log.warning("homing failed, resetting: %s", error)
            driver.recover(permit)
            state = _home(runtime, permit) or state
        if not runtime.robot.calibration and _can_calibrate(runtime):
            runtime.keep_calibration(calibrate(driver, runtime.pictures.settle, permit))
            state = _home(runtime, permit) or state
    runtime.remember(state)
    if not runtime.pictures.eyes:
        return
    frame, verdict = runtime.pictures.still(state, grant, None)
    if verdict.reason in ("black", "frozen", "camera stopped"):
        raise CameraFault(f"The camera is {verdict.reason}.")
    if frame is None:
        raise CameraFault("The picture could not be kept: the disk may be full.")


def _home(runtime: "Runtime", permit: Permit) -> RobotState | None:
    driver, state = runtime.driver, None
    for kind in driver.features.handover:
        state = driver.execute(kind, {}, permit, lambda _: None).state
    return state


def _can_calibrate(runtime: "Runtime") -> bool:
    kinds = {c.kind for c in runtime.driver.features.commands}
    return {"up", "down", "air", "move"} <= kinds
