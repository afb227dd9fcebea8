"""`make mutants`: break a promise on purpose; its test has to turn red.

Each mutant is one small change of one file, made in a copy of the tree. The test is run
without it first, because a test that fails anyway shows nothing.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORLD = "tests/world"
PRESS = f"{WORLD}/test_stops.py::test_a_press_after_a_release_counts[seed1]"
RULES, BOUNDS = f"{WORLD}/test_rules.py", f"{WORLD}/test_bounds.py"
OUTSIDE = f"{BOUNDS}::test_promise_09_a_value_outside_its_bounds_moves_nothing"
LAPSED = (
    f"{WORLD}/test_promises.py::"
    "test_promise_04_an_owner_that_goes_on_after_its_lease_moves_nothing_before_it_has_the_next"
)


@dataclass(frozen=True)
class Mutant:
    """What is broken: in `path`, `old` becomes `new`; `test` must fail."""

    promise: int
    what: str
    path: str
    old: str
    new: str
    test: str
    database: str = "sqlite"


MUTANTS = (
    Mutant(1, "a claim does not look at the state", "workers/commands/rows.py",
           "filter(pk=ID, state=CommandState.QUEUED, epoch=EPOCH, deadline__gt=NOW)",
           "filter(pk=ID, deadline__gt=NOW)",
           "tests/services/test_claim.py::test_a_command_is_claimed_once_however_often_it_is_delivered"),
    Mutant(1, "the same sequence number makes a new row", "robots/services/commands.py",
           "        return _same(Command.objects.get(pk=counted.same), robot, user, kind, args)\n    if (counted",
           "        client_seq = next_seq(grant)\n    if (counted",
           f"{WORLD}/test_promises.py::test_promise_01_one_command_at_most_one_motion[seed1-mercury]"),
    Mutant(2, "an interrupted command is queued again", "workers/commands/rows.py",
           "        if packages:\n            packages.end(command)\n    return left",
           "        if packages:\n            packages.end(command)\n"
           "        from robots.models import Lease\n"
           "        Command.objects.filter(pk=command.pk).update(state='queued', ended_at=None, "
           "epoch=Lease.objects.get(robot=robot).epoch)\n    return left",
           f"{WORLD}/test_promises.py::test_promise_02_a_crash_means_unknown_never_replay[seed1-mercury]"),
    Mutant(3, "a claim does not look at the deadline", "workers/commands/rows.py",
           "state=CommandState.QUEUED, epoch=EPOCH, deadline__gt=NOW)", "state=CommandState.QUEUED, epoch=EPOCH)",
           "tests/services/test_claim.py::test_a_late_command_is_not_claimed_and_expires"),
    Mutant(3, "nothing asks for the deadline at the line", "workers/authority/gate.py",
           "        if self.begin_by is not None and self._now >= self.begin_by:\n", "        if False:\n",
           f"{WORLD}/test_promises.py::test_promise_03_claimed_in_time_but_said_too_late[seed1-mercury]"),
    Mutant(4, "the gate does not ask for the lease", "workers/authority/gate.py",
           "        if not self.authority.lease.valid:\n", "        if False:\n", f"{LAPSED}[seed3-mercury]"),
    Mutant(4, "a frozen owner is not killed", "workers/authority/lease.py",
           "        self._processes.kill_recorded_owner(lease)\n", "",
           f"{WORLD}/test_promises.py::test_promise_04_a_frozen_owner_moves_nothing_and_is_killed[seed1-mercury]"),
    Mutant(4, "its owner believes that a grant never ends", "workers/authority/memory.py",
           "        if grant_id in self.ended_ids or not grant_id:\n            return -math.inf\n"
           "        return self._clock.monotonic() + self._left(grant_id)\n", "        return math.inf\n",
           f"{RULES}::test_nothing_begins_to_move_without_a_grant[seed1]"),
    Mutant(5, "the lease is taken from whoever has it", "workers/authority/lease.py",
           "        if not self._over(lease):\n            return False\n", "",
           f"{WORLD}/test_promises.py::test_promise_05_one_owner_however_many_start[seed1-mercury]"),
    Mutant(6, "silence of the controls is not noticed", "workers/guard/deadman.py",
           "            if now - self._heard > SILENT_S:\n", "            if False:\n",
           f"{WORLD}/test_stops.py::test_a_held_motion_ends_with_its_controls[seed1-mercury]"),
    Mutant(6, "silence of the controls is noticed after a second", "workers/guard/deadman.py",
           "SILENT_S = 0.25", "SILENT_S = 1.0",
           f"{WORLD}/test_stops.py::test_a_held_motion_ends_with_its_controls[seed1-mercury]"),
    Mutant(6, "a late keep-alive brings the motion back", "workers/guard/deadman.py",
           "            elif now - self._heard <= SILENT_S:\n", "            else:\n",
           "tests/unit/test_deadman.py::test_a_keep_alive_that_comes_too_late_brings_nothing_back"),
    Mutant(6, "a held motion that waited begins unheard", "workers/guard/deadman.py",
           "self._heard, self._released = self._waiting.pop(which, -inf), which", "self._heard, self._released = now, which",
           "tests/services/test_held_waits.py::test_a_held_motion_that_waited_unheard_moves_nothing[1.5-pa10-jog_tool-args1]"),
    Mutant(7, "a stop travels behind the commands", "workers/guard/listen.py",
           '                    self._stop.halt("bus")\n', "                    pass\n",
           f"{WORLD}/test_promises.py::test_promise_07_the_latch_survives_a_death_of_everything[seed1-mercury]"),
    Mutant(7, "a dead Redis holds nothing", "workers/authority/memory.py",
           "        return self._clock.monotonic() - self._seen_at > self._gone_s\n", "        return False\n",
           f"{WORLD}/test_promises.py::test_promise_07_with_the_store_dead_the_owner_stops_by_itself[seed1-mercury]"),
    Mutant(7, "what may go on without a connection goes on for ever", "workers/authority/gate.py",
           "not now < lost_at + alone.seconds or ", "",
           "tests/services/test_policies.py::test_a_kind_with_a_bound_goes_on_for_its_seconds_and_no_longer"),
    Mutant(8, "a release that waits for a hold undoes a press before it", "workers/guard/stop.py",
           "            if self._unwritten(releases):\n                return\n", "", PRESS),
    Mutant(8, "a press after a release is taken for the second of a double", "workers/guard/stop.py",
           "                    latch.forbid(releases)  # the release that waits for this hold was before the press\n",
           "                    pass\n", PRESS),
    Mutant(8, "a hold delays what reads the rows of stop and releases", "workers/guard/stop.py",
           "            latch.row_pending = False\n        elif latch.latched and self._unwritten",
           "            latch.row_pending = False\n            self.hold_due()\n        elif latch.latched and self._unwritten",
           PRESS),
    Mutant(8, "the gate does not ask for the latch", "workers/authority/gate.py",
           "        if self.authority.latch.latched:\n", "        if False:\n",
           f"{WORLD}/test_stops.py::test_a_stop_overtakes_everything[seed1-mercury]"),
    Mutant(8, "a press that waits for a hold counts the releases of after its wait", "workers/guard/stop.py",
           "        releases = self._releases if releases is None else releases  # as of the press, not of the end of a hold\n"
           "        with self._halting:\n",
           "        with self._halting:\n            releases = self._releases if releases is None else releases\n",
           f"{WORLD}/test_stops.py::test_a_release_after_a_press_counts[seed1]"),
    Mutant(8, "the latch is not written to disk", "workers/authority/memory.py",
           '                    os.write(descriptor, b"1")\n', '                    self._path.unlink()\n',
           f"{WORLD}/test_promises.py::test_promise_07_the_latch_survives_a_death_of_everything[seed1-mercury]"),
    Mutant(9, "the sand's edge is not checked", "robots/kit/drivers/mercury/checks.py",
           'near, far = description["sand"][axis]', "near, far = -9.0, 9.0",
           "tests/faults/test_promises_wire.py::test_promise_09_nothing_outside_the_envelope_gets_through"),
    Mutant(9, "the server does not look at values", "robots/services/commands.py",
           "        check(robot.driver, kind, args, robot.driver_settings(), state)\n", "", f"{OUTSIDE}[seed1-mercury]"),
    Mutant(9, "the iRat's driver does not look at values", "robots/kit/drivers/irat/driver.py",
           '        check("irat", kind, args, self.settings)\n', "", f"{OUTSIDE}[seed1-irat]"),
    Mutant(11, "what was held is told as completed", "workers/commands/run.py",
           "CommandState.CANCELLED if held else CommandState.FAILED",
           "CommandState.COMPLETED if held else CommandState.FAILED",
           f"{RULES}::test_what_is_completed_came_to_its_end[seed1-mercury]"),
    Mutant(11, "what waits for an owner that has died waits for ever", "workers/commands/rows.py",
           "command.state == CommandState.QUEUED and (not ours or command.deadline <= now):",
           "command.state == CommandState.QUEUED and ours and command.deadline <= now:",
           f"{RULES}::test_every_command_is_over_in_time[seed1-mercury]"),
    Mutant(30, "what changed while a page read its person's places is not read again", "portal/live/subscriptions.py",
           "        if self._told & queues:\n            self.changed.set()\n", "",
           f"{WORLD}/test_sockets.py::test_an_offer_that_is_made_while_a_page_reads_is_told_at_once[seed3]"),
    Mutant(34, "a turn is not noted with the session in which it was accepted", "queueing/offers.py",
           "            if session:\n                TurnSession.objects.create(turn=turn, session=session, last_seen=now)\n", "",
           f"{WORLD}/test_sockets.py::test_who_signs_out_on_one_page_keeps_the_turn_accepted_on_another[seed3]"),
    Mutant(34, "the other session has 0.6 s to say that it drives on", "portal/live/presence.py",
           "            if reported is not None and now - reported < LATELY:\n                return\n", "",
           f"{WORLD}/test_sockets.py::test_who_signs_out_on_one_page_drives_on_in_another_on_a_busy_machine[seed18]"),
    Mutant(34, "a page that is not the robot's does not say that its session is open", "portal/live/person_socket.py",
           "        self.begin(self._check_in())\n", "",
           f"{WORLD}/test_sockets.py::"
           "test_who_signs_out_elsewhere_keeps_the_turn_whose_page_is_not_open_yet[seed1]"),
    Mutant(43, "an earlier permit still lets through after the lease was taken again", "workers/authority/gate.py",
           "if lease.epoch != meant:", "if lease.epoch < meant:",
           "tests/services/test_regain.py::test_an_earlier_permit_refuses_for_good"),
    Mutant(43, "a renewal that comes too late brings the lease back", "workers/authority/lease.py",
           "elif self._lapsed or self._clock.monotonic() >= self._until:", "elif False:",
           "tests/services/test_regain.py::test_a_renewal_that_comes_too_late_brings_nothing_back"),
    Mutant(43, "what ran when the lease ran out is called by its end", "workers/commands/run.py",
           "if self._said == command.pk and self._stale(command):", "if False:",
           f"{LAPSED}[seed1-mercury]"),
    Mutant(44, "a number on the wire is not bounded", "robots/kit/drivers/mercury/protocol.py",
           "    if not all(-greatest <= value <= greatest for value in values):", "    if False:",
           "tests/drivers/test_mercury_wire.py::test_no_number_is_believed_that_cannot_be_meant"),
    Mutant(44, "an unfinished frame hides what follows it", "robots/kit/drivers/mercury/framing.py",
           "        for i in range(first, len(self._buffer)):", "        for i in range(first, 1):",
           "tests/drivers/test_mercury_fuzz.py::test_promise_44_a_hostile_wire_client_changes_nothing[1]"),
    Mutant(44, "the museum arm's wire takes any number", "robots/kit/drivers/pa10/protocol.py",
           "if not value.low <= found <= value.high or (value.whole and found != int(found)):", "if found == 0.123:",
           "tests/unit/test_pa10_protocol.py::test_no_number_outside_its_bounds_is_read"),
    Mutant(44, "whoever connects to the museum arm takes it over", "simulators/pa10/server.py",
           "            if other is not None and not (claims", "            if False and not (claims",
           f"{BOUNDS}::test_promise_44_a_hostile_client_beside_the_owner_changes_nothing[seed1-pa10]"),
    Mutant(44, "the end of the museum arm's connection does not hold", "simulators/pa10/server.py",
           "        self._arm.hold()\n        self._note(\"disconnected\"", "        self._note(\"disconnected\"",
           "tests/drivers/test_pa10_wire.py::test_the_end_of_the_only_clients_connection_holds_at_once"),
    Mutant(44, "a hold waits for its place in the row", "simulators/pa10/server.py",
           'if text.split() == ["h"] and self._present is client:', "if False:",
           "tests/drivers/test_pa10_wire.py::test_a_hold_overtakes_a_row_of_lines_and_what_stood_before_it_does_not_begin"),
    Mutant(44, "the iRat's wire takes any number", "robots/kit/drivers/rosbridge.py",
           "    if not low <= value <= high:", "    if value == 0.123:",
           "tests/unit/test_irat_protocol.py::test_numbers_are_finite_and_bounded"),
    Mutant(44, "a stale epoch commands the iRat", "simulators/irat/claims.py",
           "        if epoch < self._newest:\n", "        if False:\n",
           "tests/drivers/test_irat_commander.py::test_a_stale_epoch_is_refused"),
    Mutant(44, "a velocity is never forgotten", "simulators/common/motor_board.py",
           'now - self._said > self._motion["forget_s"]:', "now - self._said > 1e9:",
           "tests/drivers/test_irat_wire.py::test_a_velocity_is_forgotten_after_a_quarter_of_a_second"),
    Mutant(44, "the iRat's hold is answered before it rests", "simulators/irat/operations.py",
           "            if rests or hold.limit.over:", "            if True:",
           "tests/drivers/test_irat_wire.py::test_a_hold_is_answered_at_rest_and_refuses_velocities_meanwhile"),
    Mutant(44, "who has not claimed the iRat drives it", "simulators/irat/operations.py",
           "        if self.claims.commander is not peer:\n", "        if False:\n",
           "tests/drivers/test_irat_wire.py::test_everybody_may_hold_and_nobody_else_drives"),
    Mutant(44, "a page in a browser reaches the iRat", "simulators/irat/server.py", "origins=[None]", "origins=None",
           "tests/drivers/test_irat_hostile.py::test_pages_in_a_browser_are_not_served"),
    Mutant(44, "an owner's client sends before it is permitted", "robots/kit/drivers/rosbridge_client.py",
           "        if permit is not None:\n            permit()\n        self._send(frame)",
           "        self._send(frame)\n        if permit is not None:\n            permit()",
           "tests/drivers/test_irat_client.py::test_a_permit_that_says_no_sends_nothing"),
    Mutant(48, "an owner that finds a stop and reaches no robot does not say by when it rests", "workers/guard/stop.py",
           "        if latch.latched:\n            self._rests_by = row", "        if False:\n            self._rests_by = row",
           f"{BOUNDS}::test_promise_48_nobody_says_that_a_robot_rests_before_it_does[killed-seed1-pa10]"),
    Mutant(48, "the time of a stop that was released is said of the next", "robots/services/stopping.py",
           'Case(When(stop_latched=True, then=F("rests_by")), default=None)', 'F("rests_by")',
           "tests/services/test_stop_confirmed.py::"
           "test_the_time_of_a_stop_that_was_released_unconfirmed_is_not_said_of_the_next"),
)  # fmt: skip


def main() -> None:
    """Print one line a mutant; fail if one stays green."""
    green = 0
    wanted = {int(a) for a in sys.argv[1:]}
    with tempfile.TemporaryDirectory(prefix="fh-mutants-") as folder:
        copy = Path(folder) / "tree"
        skip = shutil.ignore_patterns(".git", ".venv", "var", "node_modules", "__pycache__", ".hypothesis", ".*_cache")
        shutil.copytree(ROOT, copy, ignore=skip)
        (copy / ".venv").symlink_to(ROOT / ".venv")
        for mutant in MUTANTS:
            if wanted and mutant.promise not in wanted:
                continue
            why = dies(copy, mutant)
            green += not why
            said = (
                f"red   promise {mutant.promise}: {mutant.what}: {why}"
                if why
                else f"GREEN promise {mutant.promise}: {mutant.what}"
            )
            print(f"{said} ({mutant.test})", flush=True)
    if green:
        sys.exit(f"{green} mutants stayed green: their tests prove nothing")


def dies(copy: Path, mutant: Mutant) -> str:
    """Apply the mutant, run its test, take it back; return how the test failed, or nothing where it did not."""
    path = copy / mutant.path
    text = path.read_text()
    if text.count(mutant.old) < 1:
        sys.exit(f"the mutant {mutant.what!r} no longer fits {mutant.path}")
    if why := fails(copy, mutant.test, mutant.database):
        sys.exit(f"{mutant.test} fails without any mutant, so that it can show nothing: {why}")
    path.write_text(text.replace(mutant.old, mutant.new, 1))
    try:
        return run(copy, mutant.test, mutant.database)
    finally:
        path.write_text(text)


@cache
def fails(copy: Path, test: str, database: str) -> str:
    """Return how a test fails in the tree as it is; asked once for each."""
    return run(copy, test, database)


def run(copy: Path, test: str, database: str) -> str:
    """Run a test; return the first line of its error, nothing where it is green."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", test], cwd=copy, check=False,
        env={**os.environ, "PYTHONPATH": ".", "FARHAND_TEST_DB": database, "FARHAND_MUTANT": "1"},
        capture_output=True, text=True, errors="replace",
    )  # fmt: skip
    if done.returncode not in (0, 1):
        sys.exit(f"{test} could not run:\n{done.stdout[-2000:]}")
    if done.returncode == 0:
        return ""
    errors = [line.strip("E ")[:120] for line in done.stdout.splitlines() if line.lstrip(" |").startswith("E  ")]
    return errors[0] if errors else "failed"


if __name__ == "__main__":
    main()
