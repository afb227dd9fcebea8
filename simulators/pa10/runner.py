"""Runs a program's steps one after the other in a thread, until the last step or a hold."""

from functools import partial
from typing import Protocol

import numpy as np

from robots.kit.arms.planner import Refused
from robots.kit.clock import Timer
from robots.kit.drivers.pa10.protocol import MOTIONS, Request

GRIP_S = 0.8


class Arm(Protocol):
    """The arm as a program uses it; `mine` is the arm's number of holds at the start of the program."""

    def step_began(self, number: int, mine: int) -> bool:
        """Note the step; return False if the program must end."""

    def move(self, request: Request, mine: int, in_program: bool) -> int:
        """Plan and start a motion. Raises Refused."""

    def grip(self, value: float) -> None:
        """Open or close the gripper."""

    def wait(self, mine: int, seconds: float, rest: bool) -> None:
        """Wait for so many seconds of the control loop, or until the arm rests."""

    def program_ended(self, mine: int, error: str = "") -> None:
        """Note the end of the program, with the error that ended it, if any."""


def start(arm: Arm, steps: list[Request], mine: int, clock: Timer) -> None:
    """Start a program that was checked against limits and boxes."""
    clock.spawn(partial(_run, arm, steps, mine), "program")


def _run(arm: Arm, steps: list[Request], mine: int) -> None:
    for number, step in enumerate(steps, 1):
        if not arm.step_began(number, mine):
            return
        try:
            _one(arm, step, mine)
        except Refused as error:
            arm.program_ended(mine, f"step {number}: {error}")
            return
    arm.program_ended(mine)


def _one(arm: Arm, step: Request, mine: int) -> None:
    if step.letter in MOTIONS:
        arm.move(step, mine, in_program=True)
        arm.wait(mine, np.inf, rest=True)
    elif step.letter == "g":
        arm.grip(step.numbers[0])
        arm.wait(mine, GRIP_S, rest=False)
    elif step.letter == "d":
        arm.wait(mine, step.numbers[0], rest=False)
