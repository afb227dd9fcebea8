"""Loaded by each Python process under libfaketime, whose own `clock_nanosleep` refuses what Python's sleep asks it."""

import select
import time


def sleep(seconds: float) -> None:
    """Sleep for so many seconds."""
    if seconds < 0:
        raise ValueError("sleep length must be non-negative")
    if seconds:
        select.select([], [], [], seconds)


time.sleep = sleep
