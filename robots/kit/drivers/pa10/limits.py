"""Limits of duration and size for commands of the museum arm."""

LONGEST_PROGRAM_S = 300.0
LONGEST_TEXT = 6000  # characters of a program
PLANNED_S = 10.0  # a motion is planned and checked before the answer, which takes longer on a busy machine
