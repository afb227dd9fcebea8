"""What commands are called, in the words of the robot's spec; all in English, to be translated where it is read."""

from collections.abc import Mapping
from typing import Any

from robots.kit.contract.find import spec_or_none
from robots.kit.contract.procedures import procedures
from robots.kit.contract.words import command_words
from robots.kit.plain import one_line


def label_of(driver: str, kind: str) -> str:
    """Return what robots of this driver call a kind of command; its name if they do not have it any more."""
    spec = spec_or_none(driver)
    known = (*spec.commands, *procedures(spec, cameras=1)) if spec is not None else ()
    label = next((one.label for one in known if one.kind == kind), "")
    return label or one_line(kind).replace("_", " ").capitalize()


def sentence_of(driver: str, kind: str, args: Mapping[str, Any]) -> str:
    """Return what a command does in a sentence."""
    spec = spec_or_none(driver)
    known = spec is not None and spec.command(kind) is not None
    return command_words(spec, kind, args) if spec is not None and known else label_of(driver, kind)
