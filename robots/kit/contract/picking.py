"""The capability of an arm that picks things up and puts them down at a place on its table. Pure data."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PickAndPut:
    """Commands that take a place on the table (`x` and `y`, m, in the frame of the robot's base), as a click gives it.

    `pick` comes from above, closes the gripper there and lifts; `put` comes down, opens it and leaves. Both are checked
    whole before the first motion, and previewed like other commands (`Preview`). Consoles offer them on the pictures of
    the calibrated cameras that the robot's description names (`[[view]]`). `feels`: the gripper tells whether something
    is between its fingers, so that a pick where nothing is known to lie is possible.
    """

    pick: str
    put: str
    feels: bool
