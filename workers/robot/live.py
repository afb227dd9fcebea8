"""The loop that sends a camera's live pictures while somebody watches it."""

from robots.kit.brownout import Brownout
from workers.media.pictures import Pictures
from workers.robot.owned import OwnedRobot

LEAST_S, LOOK_S = 0.01, 0.5


def send_live(owned: OwnedRobot, pictures: Pictures, brownout: Brownout, camera: int = 0) -> None:
    """Send pictures of camera number `camera` at its rate until the owner ends."""
    clock, sent, least_s = owned.clock, owned.clock.monotonic(), LEAST_S
    while owned.running:
        due = sent + brownout.every_s(pictures.every_s)
        clock.sleep(min(max(due - clock.monotonic(), least_s), LOOK_S))
        now = clock.monotonic()
        if now < due:
            continue  # the rate may have changed: the machine is less busy now
        sent = due if now - due < pictures.every_s else now
        least_s = LEAST_S if pictures.live_once(owned.driver.latest(), camera) else LOOK_S
