"""How long and how large a command of the museum arm may be."""

LONGEST_PROGRAM_S = 300.0
LONGEST_TEXT = 6000  # characters of a program
PLANNED_S = 10.0  # a motion is planned and swept before it is answered; a crowded machine takes its time
