"""Validators for the fields of a robot that staff edit."""

from collections.abc import Callable
from math import isfinite

from django.core.exceptions import ValidationError
from django.utils.translation import gettext

from robots.kit import addresses
from robots.sentences import translate

TURN_S = (10, 86_400)


def _in_words(check: Callable[[str], None], text: str) -> None:
    try:
        check(text)
    except addresses.AddressError as error:
        raise ValidationError(translate(error)) from error


def robot_address(text: str) -> None:
    """Refuse text that is not the address of a robot. Raises ValidationError."""
    _in_words(addresses.check_robot, text)


def camera_addresses(text: str) -> None:
    """Refuse text that is not a list of camera addresses. Raises ValidationError."""
    _in_words(addresses.check_cameras, text)


def microphone_address(text: str) -> None:
    """Refuse text that is not the address of a microphone. Raises ValidationError."""
    _in_words(addresses.check_microphone, text)


def positive(value: float) -> None:
    """Refuse zero, negative numbers and NaN. Raises ValidationError."""
    if not (isfinite(value) and value > 0):
        raise ValidationError(gettext("Write a number greater than zero, or leave it empty."))


def a_turn(seconds: int) -> None:
    """Refuse a length of turn that is too short or too long. Raises ValidationError."""
    if not TURN_S[0] <= seconds <= TURN_S[1]:
        words = gettext("A turn takes {least} to {most} seconds.")
        raise ValidationError(words.format(least=TURN_S[0], most=TURN_S[1]))
