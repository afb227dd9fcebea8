"""The same wishes for unlike robots: what a test asks for in words, spelt as each robot's own commands."""

import termios

from robots.kit.arms.described import chain, posture
from robots.kit.description import load
from robots.kit.drivers.irat.choices import choices
from robots.kit.drivers.srv1.hall import hall
from robots.services.streams import packets_of
from tests.drivers.mercury_wire import STATE, STATUS, Terminal, frame
from tests.rig import ArmSimulator, IratSimulator, PumaSimulator, RoverSimulator, Simulator
from tests.waiting import wait_for


def motions(journal):
    """Return the simulator's notes of each motion."""
    return [record for record in journal if record["event"] == "motion"]


def disconnected(sim):
    """Wait until the simulator has read what the last client sent before it ended, and its end."""

    def read():
        status = sim.status()
        open_lines = status["counts"].get("connected", 0) - status["counts"].get("disconnected", 0)
        return open_lines == 0 and "client" not in status["threads"]  # the arm's works off its lines in one

    wait_for(read, 10, "the end of the connection")


class Mercury:
    """Four axes over sand, behind a serial line."""

    name = "mercury"
    simulator = Simulator
    faults = (
        "awol", "slow", "drop", "corrupt", "power_cycle", "limit_hit", "cam_gone", "cam_black", "cam_freeze", "cam_slow",
    )  # fmt: skip
    strengths = {"drop": 0.5, "corrupt": 0.5, "slow": 0.5}
    one_at_a_time = by_staff = False
    pause_s = 8.0  # between two wishes of somebody, at most

    def motions(self, journal):
        """Return the motions that were commanded: not the way back to the last place, which ends a soft reset.

        A soft reset's instructions have numbers that follow one another: calibrate, speed, move.
        """
        found, back = [], 0
        for record in journal:
            if record["event"] == "calibrate":
                back = (record["seq"] + 1) % 255 + 1
            elif record["event"] == "motion" and record["seq"] == back:
                back = 0
            elif record["event"] == "motion":
                found.append(record)
        return found

    def drained(self, sim):
        """Return once the simulator has read what the last owner, which has ended, has sent.

        A question of our own comes after it on the same line. It is asked again where the last owner was cut off in the
        middle of a message: of its own, or of one of the robot's.
        """
        for number in range(250, 256):
            terminal = Terminal(sim.folder / "tty")
            try:
                termios.tcflush(terminal.descriptor, termios.TCIFLUSH)  # what was meant for it
                terminal.write(frame(STATUS, number))
                if terminal.until(lambda heard, n=number: any(h[:2] == (STATE, n) for h in heard), 1.0):
                    return
            finally:
                terminal.close()
        raise AssertionError("the robot's line does not answer")

    def spell(self, kind, args, share):
        return kind, args

    def job(self, robot, place, dice):
        """Return what somebody asks the robot for who does not drive it."""
        return self.spell("move", place, None)

    def goal(self, command):
        """Return where a command asked the robot to go, as the simulator notes it."""
        return round(command.args["x"], 4), round(command.args["y"], 4)

    def made(self, record):
        return tuple(round(v, 4) for v in record["target"][:2])

    moves = ("move",)
    restart, cut = "power_cycle", ("cable", "serial")

    def jog(self, direction):
        return "jog", {"dx": direction, "dy": 0.3}


class MuseumArm:
    """Six axes over a table, behind TCP: a place over the sand is a posture here."""

    name = "pa10"
    simulator = ArmSimulator
    faults = ("awol", "slow", "restart", "disturb", "cam_gone", "cam_black", "cam_freeze", "cam_slow")
    strengths = {"slow": 0.5, "disturb": 60.0}
    moves = ("joints",)
    restart, cut = "restart", ("arm",)
    one_at_a_time = True  # a newer target replaces the one before
    by_staff = False
    pause_s = 8.0
    turning, bending, nodding = "S1", "E1", "W1"  # the joints that a place over the sand, and a jog, turn
    aside, reach = 0.0, 4.0  # rad; rad/m
    motions = staticmethod(motions)
    drained = staticmethod(disconnected)

    def jog(self, direction):
        return "jog_joints", {self.turning: direction, self.nodding: 0.5 * direction}  # there and back

    def spell(self, kind, args, share):
        if kind == "move":
            ready = dict(zip(chain(self.name).names, posture(load(self.name), "ready"), strict=True))
            ready[self.turning] += self.aside + self.reach * args["x"]
            ready[self.bending] += args["y"] - 0.4
            return "joints", {k: float(v) for k, v in ready.items()} | ({"speed": share} if share else {})
        if kind in ("up", "down"):
            return "gripper", {"closed": float(kind == "down")}
        return kind, args

    def job(self, robot, place, dice):
        """Return a task, the only thing for which people who do not drive the arm can ask."""
        return "task", {"text": "\n".join(("move ready", "wait 1", "expect empty"))}

    def goal(self, command):
        return tuple(round(command.args[name], 4) for name in chain(self.name).names)

    def made(self, record):
        return tuple(round(v, 4) for v in record.get("target", ()))


class VirtualArm(MuseumArm):
    """Six axes over a table, behind a serial line; it takes no target in motion."""

    name = "puma"
    simulator = PumaSimulator
    faults = ("awol", "slow", "power_cycle", "disturb", "cam_gone", "cam_black", "cam_freeze", "cam_slow")
    restart, cut = "power_cycle", ("line",)
    one_at_a_time = False
    turning, bending, nodding = "J1", "J3", "J5"
    aside, reach = -0.9, 2.0  # away from the threads


class Irat:
    """Two wheels in a maze, behind rosbridge: a place over the sand is a velocity here, held for a moment.

    Each place has a velocity of its own, in a small circle, so that the robot stays where it is.
    """

    name = "irat"
    faults = (
        "awol", "power_cycle", "mute", "slow", "stall", "slip", "ir_dead", "cam_gone", "cam_black", "cam_freeze", "cam_slow",
    )  # fmt: skip
    strengths = {"slow": 0.5, "ir_dead": 7.0}
    moves = ("drive",)
    restart, cut = "power_cycle", ("rosbridge",)
    one_at_a_time = by_staff = True
    corridor = 50  # in the left arm of the U
    pause_s = 40.0  # it looks around meanwhile, and then knows more places
    moment_s = 1.0  # of a motion at full speed; a slow one is held for longer
    silent_meanwhile = ()  # faults of a camera for which the robot waits, and answers nothing but a hold
    drained = staticmethod(disconnected)

    def simulator(self, folder):
        sim = IratSimulator(folder)
        sim.fault("carried", self.corridor)
        return sim

    def jog(self, direction):
        return "drive", {"forward": direction, "turn": 0.5}

    def job(self, robot, place, dice):
        """Return the goal of somebody who chooses among the places that the robot has shown; any, where it has not."""
        known = choices(packets_of(robot, "map"))
        return "goal", dice.choice(known)[1] if known else {"map": 1, "x": 0.0, "y": 0.0}

    def spell(self, kind, args, share):
        if kind == "move":
            return "drive", {"forward": round(2 * args["x"], 6), "turn": round(1.8 * args["y"], 6)}
        if kind in ("up", "down"):
            return "drive", {"forward": 0.0, "turn": 1.0 if kind == "up" else -1.0}
        if kind == "noop":
            return "pruning", {"on": 0.0}
        return kind, args

    def goal(self, command):
        hand = load("irat")["hand"]
        return round(command.args["forward"] * hand["speed"], 6), round(command.args["turn"] * hand["turn"], 6)

    def made(self, record):
        return round(record["linear"], 6), round(record["angular"], 6)

    def motions(self, journal):
        """Return the motions. One that rested because velocities came late goes on with the same velocity: it is one.

        The robot forgets a velocity after a quarter of a second, so a machine that stalls divides a motion.
        """
        found, end = [], ""
        for record in journal:
            if record["event"] == "rest":
                end = record["end"]
            elif record["event"] in ("hold", "connected", "disconnected", "power_on"):
                end = ""
            elif record["event"] == "motion":
                last = found[-1] if found else {"epoch": None}
                goes_on = last["epoch"] == record["epoch"] and self.made(last) == self.made(record)
                if not (end == "silence" and goes_on):
                    found.append(record)
        return found


class Rover(Irat):
    """Four wheels in a hall, behind TCP: a place over the sand is a velocity here, as with the iRat.

    Its wire carries mm/s and mrad/s: places 0.2 mm apart are turns 1 mrad/s apart.
    """

    name = "srv1"
    faults = (
        "awol", "power_cycle", "mute", "slow", "slip", "blind_infrared", "cam_gone", "cam_black", "cam_freeze", "cam_slow",
    )  # fmt: skip
    strengths = {"slow": 0.2}
    cut = ("rover cannot be reached", "connection to the rover")
    silent_meanwhile = ("cam_slow",)  # its firmware does one thing at a time
    by_staff = False

    def simulator(self, folder):
        return RoverSimulator(folder)

    def spell(self, kind, args, share):
        if kind == "move":
            x, y = args["x"], args["y"]
            return "drive", {"forward": round(x, 6), "turn": round(1.2 * y + 5 * (x - round(x, 1)), 6)}
        if kind == "noop":
            return "turn", {"angle": 0.0}
        return super().spell(kind, args, share)

    def job(self, robot, place, dice):
        """Return a place of the map that somebody asks for."""
        x, y = dice.choice(hall().nodes).at
        return "go", {"x": x, "y": y}

    def goal(self, command):
        motion, args = load("srv1")["motion"], command.args
        return round(args["forward"] * motion["most_speed"], 3), round(args["turn"] * motion["turn"] / 2, 3)

    def made(self, record):
        return round(record["linear"], 3), round(record["angular"], 3)


ROBOTS = {robot.name: robot for robot in (Mercury(), MuseumArm(), VirtualArm(), Irat(), Rover())}
