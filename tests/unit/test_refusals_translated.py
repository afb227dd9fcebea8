"""What robots really answer is found in the catalogue: refusals of each driver, and commands in words.

The pseudo-language is made of the sentences that tools/sentences.py finds, so what it leaves in English nobody can
translate.
"""

import random
import re
from math import radians

import pytest
from babel.messages import Message

from queueing.words import PLACE_ENDS, TURN_ENDS, join_said, wait_said
from robots.dates import length_words
from robots.kit.arms.objects import TABLE
from robots.kit.arms.plates import PLATE
from robots.kit.arms.tasks.parsing import ALLOWED
from robots.kit.contract.capabilities import Preview
from robots.kit.contract.errors import RobotError
from robots.kit.contract.find import function, spec_of
from robots.kit.contract.spec import Argument
from robots.kit.contract.values import check
from robots.kit.contract.words import command_words, place_words, way_words
from robots.kit.description import load
from robots.kit.sentences import Sentences
from robots.states import CommandState, Cycle, GrantEnd, GrantKind, Lane
from tools.sentences import sentences
from tools.translations import ROOT, turned

DRIVERS = ("irat", "mercury", "pa10", "puma", "so101", "srv1")
MARKED, QUOTED = re.compile("\u202e[^\u202c]*\u202c"), re.compile(r"'[^']*'|\"[^\"]*\"|“[^”]*”")
WORD = re.compile(r"[A-Za-z_]{2,}")
UNITS = {"cm", "mm", "min", "rad", "px", "deg", "surprise"}
LANGUAGE = {*ALLOWED, "on", "at", "by", "turned", "holding", "empty"}  # of tasks, for all readers
TASKS = (
    "", "grasp", "grasp nothing", "put red on red", "put red", "put red on plate at 99 1", "move", "move 1 2", "move up",
    "wait", "wait 1000", "expect", "expect red", "repeat 2", "end", "repeat x\nend", "repeat 2\nend", "swim", "x" * 300,
    "grasp red\n" * 400, "repeat 50\nrepeat 50\nopen\nend\nend", "grasp !", "open now", "put red at 0 0\ngrasp green",
    "repeat 2\n" * 9 + "open\n" + "end\n" * 9, "put blue on table", "expect holding red", "move 9000 0 0", "put a on b",
    "expect a on b", "grasp rod\ngrasp a", "grasp a\ngrasp b", "grasp red\ngrasp blue",
)  # fmt: skip
MISSIONS = (
    "", "go", "go nowhere", "go 99 1", "go 1 99", "turn 999", "turn", "wait x", "patrol 0", "say", "swim", "x" * 300,
    "wait 1\n" * 200, "say \u0007", "wait 900\nwait 900", "go 0.01 0.01", "patrol 60\ngo 1 1", "x" * 99999,
)  # fmt: skip
PROGRAMS = (
    "", "x", "j 1", "j 1 2 3 4 5 x", "j 1 2 3 4 5 99999", "g 0.5", "R 2", "E", "R 3\n" * 20, "d 1\n" * 900, "é", "w",
    "R 101\nE", "g 1 2 3", "d 1\n" * 501, "k 0 0 0 0 0 0", "b 1", "p 1", "j 0 0 0 0 0 0 7", "s", "d 99", "j" * 200,
)  # fmt: skip
RULES = (
    "method x", "method sugeno", "input", "nothing", "x" * 9999,
    "method sugeno\ninput range: near 0.1, far 1\ninput bearing: left -1, right 1\noutput speed: slow 0.1, fast 0.5",
)  # fmt: skip
TEXTS = (*TASKS, *MISSIONS, *PROGRAMS, *RULES, "x" * 99999, "a\x00b", 7, None)
NUMBERS = (None, "x", True, float("nan"), 10**400, -1e9, 1e9, 0.5)


@pytest.fixture(scope="module")
def pseudo() -> Sentences:
    """The sentences of the pseudo-language."""
    return Sentences({text: str(turned(Message(text)).string) for text in sentences(ROOT)})


def english(pseudo: Sentences, text: str, names: set[str]) -> list[str]:
    """Return the words that stay English and are no names, units or words of people."""
    rest = QUOTED.sub("", MARKED.sub("", pseudo.translate(text)))
    return [word for word in WORD.findall(rest) if word not in names | UNITS]


def names_of(driver: str) -> set[str]:
    """Return the words by which people and programs call robots' parts, which are no words of a language."""
    spec = spec_of(driver)
    table = "".join(path.read_text() for path in (ROOT / "robots/kit/drivers").glob("*/robot.toml"))
    found = {PLATE, TABLE} | {argument.name for command in spec.commands for argument in command.arguments}
    found |= {command.kind for command in spec.commands} | {setting.name for setting in spec.settings()}
    return found | {*LANGUAGE, *WORD.findall(" ".join(re.findall(r'^name = "(.*)"', table, re.MULTILINE)))}


def refusals(driver: str) -> set[str]:
    """Return what a robot's own check answers to values that it does not take."""
    told = set()
    spec = spec_of(driver)
    preview = spec.capability(Preview)
    for command in spec.commands:
        middle = {
            a.name: "open" if a.text else (a.low + a.high) / 2 if not a.whole else max(a.low, 1.0)
            for a in command.arguments
        }
        tries = [
            {},
            middle,
            middle | {"surprise": 1.0},
            [],
            middle | {a.name: a.low for a in command.arguments if not a.text},
        ]
        for argument in command.arguments:
            tries += [middle | {argument.name: value} for value in (TEXTS if argument.text else NUMBERS)]
            tries.append({name: value for name, value in middle.items() if name != argument.name})
        for args in tries:
            told |= raised(check, driver, command.kind, args, {})
        if preview is not None and not command.held:
            told |= raised(function(preview.function), command.kind, middle, (), {})
    told |= raised(check, driver, "nothing", {}, {})
    return told


def raised(call, *args) -> set[str]:
    """Return the sentence of the refusal, if there is one."""
    try:
        call(*args)
    except RobotError as error:
        return {str(error)}
    return set()


@pytest.mark.parametrize("driver", DRIVERS)
def test_every_refusal_of_a_robots_values_is_translated(pseudo, driver):
    names = names_of(driver)
    told = refusals(driver)
    assert len(told) > 3
    left = {text: words for text in told if (words := english(pseudo, text, names))}
    assert not left


@pytest.mark.parametrize("driver", DRIVERS)
def test_commands_ways_and_places_are_translated(pseudo, driver):
    spec = spec_of(driver)
    coordinates = spec.pose.coordinates if spec.pose else ()
    before, after = dict.fromkeys(coordinates, 0.1), dict.fromkeys(coordinates, -0.3)
    told = {way_words(spec, before, after), way_words(spec, after, before), place_words(spec, before)}
    for command in spec.commands:
        for share in (0.0, 0.4, 1.0):
            args = {a.name: "“go”" if a.text else a.low + share * (a.high - a.low) for a in command.arguments}
            told |= {command_words(spec, command.kind, args, at) for at in (None, before, after)}
        told.add(command_words(spec, command.kind, {}))
    names = {name for name in spec.names() if len(name) < 3} | {"dx", "dy", "dz", "rx", "ry", "rz"}
    assert not {text: words for text in told if (words := english(pseudo, text, names))}


@pytest.mark.parametrize("driver", ["pa10", "puma", "srv1"])
def test_what_a_preview_foresees_is_translated(pseudo, driver):
    dice, told = random.Random(driver), set()
    spec, description = spec_of(driver), load(driver)
    foresee = function(spec.capability(Preview).function)
    start = (6.0, 4.0, 0.0) if driver == "srv1" else tuple(map(radians, description["arm"]["ready_deg"]))
    for command in spec.commands:
        for _ in range(0 if command.held or command.lane == "config" else 12):
            args = {a.name: anything(dice, a) for a in command.arguments}
            try:
                told |= {judgement.sentence for judgement in foresee(command.kind, args, start, {}).judgements}
            except RobotError as error:
                told.add(str(error))
    assert any(text.startswith("Will not run") for text in told)
    assert not {text: words for text in told if (words := english(pseudo, text, names_of(driver)))}


def anything(dice: random.Random, argument: Argument) -> float | str:
    """Return a value that the argument may have."""
    if argument.text:
        return dice.choice(TASKS + MISSIONS)[:3000]
    return dice.uniform(max(argument.low, -7.0), min(argument.high, 7.0))


def test_waits_and_ends_are_translated(pseudo):
    waits = [None, *((low, low + more) for low in (0, 20, 90, 9000) for more in (0, 30, 600, 9000))]
    told = {wait_said(wait) for wait in waits} | {
        join_said("ready", free, wait) for wait in waits for free in (True, False)
    }
    lengths = dict.fromkeys(("used", "idle", "reconnect", "silent"), length_words(125))
    for end in (*TURN_ENDS.values(), *PLACE_ENDS.values()):
        told |= {end.why.format(**lengths), end.credited.format(**lengths), end.next}
    told |= {str(label) for choices in (CommandState, Cycle, GrantKind, GrantEnd, Lane) for label in choices.labels}
    assert not {text: words for text in told if (words := english(pseudo, text, set()))}
