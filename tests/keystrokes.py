"""The keystroke-level model (Card, Moran, Newell 1980) of the way from the first page to the first motion.

A decision, a pointing, a press, a key; and how fast adults read English (Brysbaert 2019).
"""

DECIDES_S, POINTS_S, PRESSES_S, TYPES_S, WORDS_MIN = 1.35, 1.1, 0.2, 0.28, 238
PRESS_S = DECIDES_S + POINTS_S + PRESSES_S
PRESSES, WITHIN_S = 10, 180  # of links, buttons and choices, with every answer right; all in all
SURVEY_WITHIN_S, ANSWER = 90, "To dig in winter, from my desk"  # the questions after a turn, each answered
MAIL_PRESSES = 2  # in the person's own program: the mail, and the link in it
FIELDS = {"email": "ada@example.org", "username": "ada", "password1": "correct horse 42"}
ALL_PRESSES = PRESSES + MAIL_PRESSES + len(FIELDS)  # one puts the caret into a field by a press, too


def reading_s(text):
    """Return how long a text takes to read (s)."""
    return 60 * len(text.split()) / WORDS_MIN


def typing_s(text):
    """Return how long a text takes to type (s)."""
    return TYPES_S * len(text)
