"""Situations that a crowd meets by chance, here on purpose: mutants show that these rules of the model can fail."""

from robots import bus, services
from robots.models import Grant
from robots.services import START_S
from tests.conftest import BOTH_AT_LENGTH
from tests.world.model import AFTER_S
from tests.world.seeds import hunts
from tests.world.test_deadlines import begun

NOOP_S = START_S + 5.0 + AFTER_S  # within which one is over, whatever happens


def judged(crowd) -> None:
    """Fail by the rules that are judged while a world runs."""
    assert not crowd.model.wrong, "\n".join(crowd.model.wrong)


@hunts(1, 10, 50, begin="crowds")
def test_nothing_begins_to_move_without_a_grant(portal):
    """Somebody holds the controls beyond the end of the turn."""
    crowd, (ada, _) = begun(portal, 15, "ada", "bob")  # for whom her turn ends
    world, turn = portal.world, ada.accept()
    portal.final(crowd.issue(ada.user, *portal.wishes.spell("move", {"x": -0.2, "y": 0.4}, None)))
    until = Grant.objects.get(pk=turn.grant_id).until
    world.sleep((until - world.now()).total_seconds() - 1.0)
    made = crowd.issue(ada.user, *portal.wishes.jog(1))
    while (world.now() - until).total_seconds() < 4.0:
        bus.send_keep_alive(portal.slug, made.pk, True)
        world.sleep(0.08)
    judged(crowd)


@BOTH_AT_LENGTH
@hunts(1, 10, 50, begin="crowds")
def test_what_is_completed_came_to_its_end(portal):
    crowd, (ada,) = begun(portal, 60, "ada")
    ada.accept()
    for _ in range(2):
        portal.final(crowd.move(ada.user))
        command = crowd.move(ada.user)
        portal.in_motion()
        services.stop(portal.robot, ada.user)
        portal.final(command)
        portal.release()
    crowd.model.check()


@BOTH_AT_LENGTH
@hunts(1, 10, 50, begin="crowds")
def test_every_command_is_over_in_time(portal):
    crowd, (ada,) = begun(portal, 120, "ada")
    ada.accept()
    crowd.move(ada.user)
    crowd.issue(ada.user, "noop", {})
    portal.in_motion()
    portal.supervisor.worker.kill()
    portal.world.sleep(NOOP_S + 2.0)
    judged(crowd)
