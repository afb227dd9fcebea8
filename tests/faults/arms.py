"""The same wishes for unlike robots: what a test asks for in words, spelt as each robot's own commands."""

from robots.description import load
from robots.motion.described import chain, posture
from tests.rig import ArmSimulator, Simulator


class Mercury:
    """Four axes over sand, behind a serial line."""

    name = "mercury"
    simulator = Simulator
    faults = (
        "awol", "slow", "drop", "corrupt", "power_cycle", "limit_hit", "cam_gone", "cam_black", "cam_freeze", "cam_slow",
    )  # fmt: skip
    strengths = {"drop": 0.5, "corrupt": 0.5, "slow": 0.5}

    def spell(self, kind, args, share):
        return kind, args

    def goal(self, command):
        """Return where a command asked the arm to go, as the simulator notes it."""
        return round(command.args["x"], 4), round(command.args["y"], 4)

    def made(self, record):
        return tuple(round(v, 4) for v in record["target"][:2])

    moves = ("move",)
    restart, cut = "power_cycle", ("cable", "serial")

    def jog(self, way):
        return "jog", {"dx": way, "dy": 0.3}


class MuseumArm:
    """Six axes over a table, behind TCP: a place over the sand is a posture here."""

    name = "pa10"
    simulator = ArmSimulator
    faults = ("awol", "slow", "restart", "disturb", "cam_gone", "cam_black", "cam_freeze", "cam_slow")
    strengths = {"slow": 0.5, "disturb": 60.0}
    moves = ("joints",)
    restart, cut = "restart", ("arm",)

    def jog(self, way):
        return "jog_joints", {"S1": way, "W1": 0.5}

    def spell(self, kind, args, share):
        if kind == "move":
            ready = dict(zip(chain("pa10").names, posture(load("pa10"), "ready"), strict=True))
            ready["S1"] += 4 * args["x"]
            ready["E1"] += args["y"] - 0.4
            return "joints", {k: float(v) for k, v in ready.items()} | ({"speed": share} if share else {})
        if kind in ("up", "down"):
            return "gripper", {"closed": float(kind == "down")}
        return kind, args

    def goal(self, command):
        return tuple(round(command.args[name], 4) for name in chain("pa10").names)

    def made(self, record):
        return tuple(round(v, 4) for v in record.get("target", ()))


ARMS = {arm.name: arm for arm in (Mercury(), MuseumArm())}
