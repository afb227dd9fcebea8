"""The robot's description in the page is in the reader's language, but for what scripts compare."""

from django.utils.translation import override

from portal.web.consoles.language import in_language

FACTS = {
    "names": ("Move", "S1"),
    "commands": [
        {
            "kind": "Move", "label": "Move", "default": {"text": "Move"},
            "arguments": [{"name": "Move", "label": "Speed", "help": "Stop", "directions": ("right", "left"), "low": 1.0}],
        }
    ],
    "labels": {"Move": "Move"},
    "words": {"S1": "Shoulder turn"},
    "hall": {"node": [{"name": "Move", "at": [1.0, 2.0]}]},
    "goals": [{"name": "Move", "title": "The figure of five bricks"}],
    "compact": None,
}  # fmt: skip


def test_labels_are_translated_and_names_and_programs_stay():
    with override("de"):
        told = in_language(FACTS)
    (command,), (argument,) = told["commands"], told["commands"][0]["arguments"]
    assert (command["kind"], command["default"]) == ("Move", {"text": "Move"})
    assert command["label"] == told["labels"]["Move"] != "Move"
    assert argument["name"] == "Move"
    assert (argument["label"], argument["directions"]) == ("Geschwindigkeit", ["nach rechts", "nach links"])
    assert (argument["low"], told["names"], told["hall"]) == (1.0, ["Move", "S1"], FACTS["hall"])
    assert told["words"]["S1"] != "Shoulder turn"
    assert told["goals"][0]["name"] == "Move"
    assert told["goals"][0]["title"] != FACTS["goals"][0]["title"]


def test_english_stays_as_it_is():
    with override("en"):
        assert in_language(FACTS)["labels"] == FACTS["labels"]
