"""The hall rover's rules in virtual time: swapped while it patrols, refused, set back, and what breaks in the middle."""

import random
from math import dist, inf
from types import SimpleNamespace

import pytest

from robots import services
from robots.admin import verbs
from robots.kit.contract.errors import BadRequest
from robots.kit.description import load
from robots.kit.drivers.srv1 import flash
from robots.kit.drivers.srv1.extension import HOLD
from robots.kit.drivers.srv1.rules import canonical, crc_of, paper
from robots.states import GrantEnd
from tests.world.seeds import hunt, hunts, seeds
from tests.world.test_srv1 import REST_S, patrolling

pytestmark = pytest.mark.parametrize("which", ["srv1"], indirect=True)
HALF = paper().replace("VS 0.08, S 0.16, M 0.24, F 0.32, VF 0.4", "VS 0.04, S 0.08, M 0.12, F 0.16, VF 0.2")
THIRD = HALF.replace("VF 0.2", "VF 0.18")
FAST = paper().replace("rule N, VF: S", "rule N, VF: VF")


def speed(portal, seconds=0.4):
    """Return the rover's mean speed (m/s) from now on, by the simulator's truth."""
    before = portal.rig.sim.world.plant.pose
    portal.world.sleep(seconds)
    return dist(before[:2], portal.rig.sim.world.plant.pose[:2]) / seconds


def in_force(portal):
    """Return the CRC of the set in force, as the firmware says; 0 for the paper's as it was made."""
    return portal.rig.sim.firmware.commander.status().rules


def put(portal, text=HALF):
    return portal.final(portal.issue("rules", text=text), 30)


def next_turn(portal):
    """End the turn, if there is one, and begin another after the handover."""
    grant = services.open_grant(portal.robot)
    if grant is not None:
        services.end_grant(grant, GrantEnd.FINISHED, "the turn is over", portal.world.now())
    portal.grant()


def on_the_way(portal):
    """Patrol along the lower wall, where the rover has looked around, and wait until it goes straight ahead."""
    portal.grant()
    portal.rig.sim.world.plant.put(1.2, 0.6, 0.0)
    command = patrolling(portal)
    status = portal.rig.sim.firmware.commander.status
    portal.until(lambda: status().mode == "patrol", 60, "the end of a look around")
    portal.world.sleep(random.Random(portal.world.seed).random())
    portal.until(lambda: status().linear > 0.15 and abs(status().angular) < 0.1, 20, "a straight way")
    return command


@hunts(2, 20, 200)
def test_rules_that_are_changed_on_patrol_halve_the_speed_there(portal):
    """The motion goes on, and is half as fast: the set was swapped between two of the firmware's ticks."""
    command = on_the_way(portal)
    before, motions, rests = speed(portal), len(portal.motions()), portal.rig.count("rest")
    changed = put(portal)
    assert (changed.state, changed.result["sent"]) == ("completed", {"crc": crc_of(HALF)})
    assert in_force(portal) == crc_of(HALF)
    portal.world.sleep(0.6)
    assert 0.42 < speed(portal) / before < 0.55
    assert (len(portal.motions()), portal.rig.count("rest")) == (motions, rests), "the motion goes on"
    command.refresh_from_db()
    assert command.state == "acknowledged"
    assert portal.owner.owned.driver.latest().values["rules"] == crc_of(HALF)


@hunts(1, 5, 50)
def test_what_explains_the_rules_is_not_sent(portal):
    """Comments stay here: the rover gets the rules alone, and a comment that is a hold holds nothing."""
    command = on_the_way(portal)
    held, hold = portal.rig.count("hold"), HOLD.decode().strip()
    changed = put(portal, f"# {hold}\n" + "\n".join(reversed(HALF.splitlines())) + f"\n\n# {hold}")
    assert changed.state == "completed", changed.reason
    assert portal.rig.sim.firmware.flash.text().decode() == canonical(changed.args["text"])
    assert b"#" not in portal.rig.sim.firmware.flash.text()
    assert in_force(portal) == crc_of(changed.args["text"])
    assert portal.rig.count("hold") == held
    command.refresh_from_db()
    assert command.state == "acknowledged"


@hunts(1, 5, 50)
def test_rules_that_are_refused_change_nothing(portal):
    """A set that cannot brake, or leaves a pair out, changes nothing; the refusal names the rule."""
    on_the_way(portal)
    before = speed(portal)
    for text, words in (
        (FAST, "Rule 10 (infrared N, sonar VF) is too fast"),
        (paper().replace("rule M, M: M\n", ""), "Rule 13 (infrared M, sonar M) is missing."),
        ("method none\n", "no line of a rule set"),
        *((f"# a{letter}b\n" + HALF, "printable ASCII|cannot be stored") for letter in "\0\x1a\ud800"),
    ):
        with pytest.raises(BadRequest, match=words.replace("(", r"\(").replace(")", r"\)")):
            portal.issue("rules", text=text)
    assert (in_force(portal), portal.rig.count("rules")) == (0, 0)
    assert speed(portal) > 0.8 * before


def by_staff(portal, text):
    """Send a rule set as staff do: lock the robot out, take it for maintenance, send, and lift that."""
    grant = services.open_grant(portal.robot)
    services.end_grant(grant, GrantEnd.FINISHED, "the turn is over", portal.world.now())
    kim = type(portal.people["kim"]).objects.get(username="kim")

    def verb(name, **post):
        return verbs.VERBS[name](portal.row, SimpleNamespace(user=kim, POST=post))

    verb("lock_out", note="new rules")
    portal.until(lambda: portal.row.stop_latched, 10, "the row of the stop")
    verb("maintenance")
    verb("release", checked="yes")
    portal.until(lambda: not portal.owner.latch.latched, 10, "the release")
    grant = services.open_grant(portal.robot)
    issued = services.issue(portal.slug, kim, "rules", {"text": text}, services.next_seq(grant)).command
    done = portal.final(issued)
    verb("lift")
    if portal.row.stop_latched:
        verb("release", checked="yes")
    return done


@hunts(1, 5, 50)
def test_an_operators_rules_are_set_back_at_handover_to_what_staff_set(portal):
    """An operator's rules are gone after the turn; those of staff stay, and come back after the next turn."""
    portal.grant()
    assert put(portal).state == "completed"
    next_turn(portal)
    assert in_force(portal) == crc_of(paper())
    assert portal.owner.owned.driver.latest().values["rules"] == 0
    assert by_staff(portal, THIRD).state == "completed"
    next_turn(portal)
    assert in_force(portal) == crc_of(THIRD), "what staff have set stays"
    assert put(portal).state == "completed"
    assert in_force(portal) == crc_of(HALF)
    next_turn(portal)
    assert in_force(portal) == crc_of(THIRD)


def switched_off(portal):
    """Switch the rover off and on, and wait until it is connected again."""
    connection = portal.owner.connection
    times = connection.times
    portal.rig.power_cycle()
    portal.until(lambda: connection.times > times and connection.connected, 60, "another connection")


def released(portal):
    """Wait until the robot is ready for anybody, after staff have had it."""
    portal.ready()
    portal.until(lambda: not portal.row.stop_latched and not portal.owner.latch.latched, 10, "the release")


def before_motions(portal, rules):
    """Fail unless that set was in force before anything moved since the rover was switched on."""
    events = [record for record in portal.rig.journal() if record["event"] in ("power_on", "rules", "motion")]
    start = max(number for number, record in enumerate(events) if record["event"] == "power_on")
    since = [(record["event"], record.get("crc")) for record in events[start:]]
    assert since[:3] == [("power_on", None), ("rules", rules), ("motion", None)]


@hunts(1, 5, 50)
def test_what_staff_approved_is_in_force_again_after_a_loss_of_power(portal):
    """Staff's rules are in force again after a loss of power, before anything moves: the firmware forgets them."""
    portal.grant()
    assert by_staff(portal, THIRD).state == "completed"
    released(portal)
    switched_off(portal)
    portal.ready()
    assert in_force(portal) == crc_of(THIRD), "nobody had the robot"
    portal.grant()
    command = patrolling(portal)
    before_motions(portal, crc_of(THIRD))
    assert put(portal).state == "completed"
    assert in_force(portal) == crc_of(HALF)
    switched_off(portal)
    assert portal.final(command).state == "failed"
    patrolling(portal)
    assert in_force(portal) == crc_of(THIRD), "in a turn, too; what its operator tried is gone"
    before_motions(portal, crc_of(THIRD))
    assert portal.owner.owned.driver.latest().values["rules"] == crc_of(THIRD)


@hunts(1, 5, 50)
def test_rules_that_nobody_approved_are_replaced(portal):
    """Somebody has stored rules in the rover's flash memory, which it reads when it starts: nothing patrols by them."""
    portal.ready()
    flash = portal.rig.sim.firmware.flash
    flash.load(HALF.encode())
    letters = iter(b"w")
    flash.do(lambda: next(letters))
    switched_off(portal)
    portal.grant()
    patrolling(portal)
    assert in_force(portal) == crc_of(paper())
    before_motions(portal, crc_of(paper()))


@hunts(1, 5, 50)
def test_a_loss_of_power_while_nobody_owns_the_rover(portal):
    """The rover loses its power while its owner is away: the next one finds it out by what the rover shows."""
    portal.grant()
    assert by_staff(portal, THIRD).state == "completed"
    released(portal)
    portal.supervisor.worker.kill()
    portal.rig.power_cycle()
    portal.until(lambda: portal.owner, 30, "another owner")
    portal.ready_again()
    next_turn(portal)
    patrolling(portal)
    before_motions(portal, crc_of(THIRD))


def slowed(portal):
    """Have each byte be on its way for a while, so that an upload lasts."""
    portal.rig.fault("slow", 0.02)


def asked(portal, text=HALF):
    """Ask for a rule set, and wait until its upload is under way."""
    before = portal.rig.blocks
    command = portal.issue("rules", text=text)
    portal.until(lambda: portal.rig.blocks > before, 5, "an upload")
    portal.world.sleep(random.Random(portal.world.seed).random() * 0.2)
    return command


@hunts(3, 20, 200)
def test_a_stop_during_the_upload(portal):
    """A stop during the upload rests the rover as always, and ends the upload; the line is in order."""
    patrol = on_the_way(portal)
    slowed(portal)
    command = asked(portal)
    took = portal.stop()
    assert took <= REST_S, f"at rest {took:.3f} s after the stop"
    assert portal.final(command, 30).state in ("rejected", "cancelled", "completed")
    assert in_force(portal) == (crc_of(HALF) if command.state == "completed" else 0)
    assert portal.final(patrol).state == "cancelled"
    portal.rig.clear_faults()
    portal.world.sleep(1)
    portal.release()
    assert put(portal).state == "completed"
    assert in_force(portal) == crc_of(HALF)


@hunts(2, 20, 200)
def test_the_line_is_lost_during_the_upload(portal):
    """The line is pulled in the middle: the rover rests by its permit's end, and takes new rules after that."""
    on_the_way(portal)
    slowed(portal)
    command = asked(portal)
    portal.rig.pull()
    at = portal.world.monotonic()
    portal.at_rest(40)
    assert portal.world.monotonic() - at <= load("srv1")["line"]["permit_s"] + REST_S
    assert portal.final(command).state == "failed"
    portal.world.sleep(random.Random(portal.world.seed).random() * 10)
    portal.rig.clear_faults()
    portal.rig.plug()
    portal.until(lambda: not portal.row.reason, 60, "another connection")
    assert in_force(portal) in (0, crc_of(HALF))  # it may have been swapped just before
    next_turn(portal)
    assert put(portal, THIRD).state == "completed"
    assert in_force(portal) == crc_of(THIRD)


@hunts(2, 20, 200)
def test_an_owner_is_killed_during_the_upload(portal):
    """An owner is killed in the middle of a block: the next one ends what it left open, whatever is lacking."""
    on_the_way(portal)
    slowed(portal)
    asked(portal)
    portal.rig.halve()
    portal.world.sleep(random.Random(portal.world.seed).random() * 0.1)
    portal.supervisor.worker.kill()
    portal.rig.clear_faults()
    portal.until(lambda: portal.owner, 30, "another owner")
    portal.until(lambda: not portal.row.reason, 60, "a connection")
    next_turn(portal)
    assert put(portal, THIRD).state == "completed"
    assert in_force(portal) == crc_of(THIRD)


def corrupted(portal, monkeypatch):
    """A block is spoilt each time it is sent: that upload is given up, and the next one puts in force what was meant."""
    on_the_way(portal)
    dice, blocks, spoilt = random.Random(portal.world.seed), flash.blocks, []

    def with_one_wrong(data):
        right = blocks(data)
        number, at = dice.randrange(len(right)), dice.randrange(3, 133)
        wrong = bytearray(right[number])
        wrong[at] ^= 1 << dice.randrange(8)
        if not spoilt:  # of the first upload
            spoilt.append(number)
            right[number] = bytes(wrong)
        return right

    monkeypatch.setattr(flash, "blocks", with_one_wrong)
    assert put(portal).state == "completed"
    assert spoilt
    assert in_force(portal) == crc_of(HALF)


@seeds(2, 10, 100)
def test_a_spoilt_byte(worlds, seed, monkeypatch):
    hunt(worlds, seed, lambda portal: corrupted(portal, monkeypatch))


@hunts(2, 10, 100)
def test_a_motion_that_ends_beside_the_upload(portal):
    """A motion that ends beside the upload holds the rover, and with it the upload, which is begun again."""
    portal.grant()
    portal.controls.moment_s = inf
    command = portal.hold_if_held(portal.issue("drive", forward=0.5, turn=0.0))
    portal.in_motion()
    slowed(portal)
    rules = asked(portal)
    portal.controls.let_go()
    portal.final(command)
    assert portal.final(rules, 30).state == "completed"
    assert in_force(portal) == crc_of(HALF)
