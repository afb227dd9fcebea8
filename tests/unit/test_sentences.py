"""Sentences of workers are translated where they are read, in Python and in the browser by the same rule.

`PYTHONPATH=. .venv/bin/python -m tests.unit.test_sentences` writes the vectors anew.
"""

import json
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from robots.kit.contract.find import spec_of
from robots.kit.contract.spec import Argument, CommandKind, Spec
from robots.kit.sentences import PLACE, Sentences, fit
from tools.sentences import of_source, of_spec, of_table

FILE = Path(__file__).resolve().parents[1] / "vectors" / "sentences.json"
CATALOGUE = {
    "The arm is off.": "Der Arm ist aus.",
    "The {name} is off.": "{name} ist aus.",
    "The arm cannot go there: {error}.": "Dorthin kann der Arm nicht: {error}.",
    "joint {name} would be at {there}°, outside {low}° to {high}°": "Gelenk {name} käme auf {there}°, außerhalb {low}° bis {high}°",
    "{held} is in the gripper": "{held} ist im Greifer",
    "the red block": "der rote Block",
    "{count} of {total}": "{count} von {total}",
    "{x} right": "{x} rechts",
    "{x} up": "{x} hoch",
    "Stop": "Halt",
    "Release": "",
    "Twice {a} and {b}": "Zweimal {b} und {a}",
    "{low} to {high}": "{low} bis {high}",
    "turn {number}": "Drehung {number}",
    "{number} m from the wall": "{number} m von der Wand",
    "{error} The arm was held.": "{error} Der Arm wurde angehalten.",
    "The gripper is empty: {what}": "Der Greifer ist leer: {what}",
    "nothing was there": "nichts war da",
    "say what? Write it": "was sagen? Schreiben Sie es",
    "nothing answers. Look.": "nichts antwortet. Schauen Sie.",
    "Line {number}, {written}: {why}.": "Zeile {number}, {written}: {why}.",
    "the {name} sees nothing": "{name} sieht nichts",
    "Staff write: “{quoted}”": "Das Personal schreibt: „{quoted}“",
    "open": "offen",
    "{where}: {why}. The arm was held.": "{where}: {why}. Der Arm wurde angehalten.",
}
TEXTS = (
    "The arm is off.", "The lamp is off.", "The arm cannot go there: the red block is in the gripper.",
    "The arm cannot go there: joint 3 would be at 200°, outside -90° to 90°.", "The arm is off. The lamp is off.",
    "3 cm right, 4 cm up", "Stop", "Stop.", "Release", "something else", "", "2 of 9", "Twice one and two and three",
    "The  is off.", "x" * 2000 + " is in the gripper", "The {name} is off.", "Stop: the red block",
    "The red block. The arm is off. Nobody knows that.", "0.5 to 3 m", "Go to bed", "-1 to 1",
    "The lamp is off. The arm is off. The arm was held.", "The gripper is empty: nothing was there.",
    "The red block: the gripper is empty: nothing was there. The arm was held.", "Nothing was there",
    "turn 1.5", "Turn in place: turn -3", "Go: 2 m from the wall, 3 m from the wall",
    "The arm cannot go there: say what? Write it.", "The arm cannot go there: say it. Write it.",
    "The arm cannot go there: nothing answers. Look.", "Line 2, open: nothing was there.", "open: Stop",
    "Line 2, open: nothing was there. The arm was held.",
    "joint 3 would be at 200.5°, outside -90.25° to 90°", "1.5 m from the wall", "turn 1.5.2", "Line 1.5, 0.5: nothing was there.",
    "The arm: the eye sees nothing, the ear sees nothing.", "Staff write: “The arm is off. Stop”", "Staff write: “Stop”",
    "Locked. Staff write: “The lamp is off.”",
    "ähnlich", "The arm is off. The lamp", "The arm is off, the red block. Stop",
)  # fmt: skip
WORD = st.text(st.sampled_from("ab ."), min_size=1, max_size=4)
LONG = "abcdef"  # letters enough for an entry that begins with a placeholder


def vectors():
    """Return the catalogue, and texts with their translations."""
    sentences = Sentences(CATALOGUE, ",")
    return {"catalogue": CATALOGUE, "texts": [[text, sentences.translate(text)] for text in TEXTS]}


def test_the_vectors_are_what_python_translates():
    assert json.loads(FILE.read_text()) == vectors()


def test_values_are_translated_too_and_the_sentence_with_most_words_wins():
    translate = Sentences(CATALOGUE).translate
    assert translate("The arm is off.") == "Der Arm ist aus."
    assert translate("The arm cannot go there: the red block is in the gripper.") == (
        "Dorthin kann der Arm nicht: der rote Block ist im Greifer."
    )
    assert translate("3 cm right, 4 cm up") == "3 cm rechts, 4 cm hoch"


def test_a_sentence_is_no_value_of_the_sentence_before_it():
    translate = Sentences(CATALOGUE).translate
    assert translate("The arm is off. The lamp is off.") == "Der Arm ist aus. lamp ist aus."
    assert translate("The arm is off. The arm was held.") == "Der Arm ist aus. Der Arm wurde angehalten."


def test_a_sentence_in_another_may_begin_with_a_small_letter():
    translate = Sentences(CATALOGUE).translate
    assert translate("Nobody knows: the gripper is empty: nothing was there.") == (
        "Nobody knows: Der Greifer ist leer: nichts war da."
    )
    assert translate("Nothing was there.") == "Nichts war da."


def test_a_placeholder_for_a_number_fits_numbers_only():
    translate = Sentences(CATALOGUE).translate
    assert translate("turn in place: turn -0.5") == "turn in place: Drehung -0.5"
    assert translate("Go: 2 m from the wall, 3 m from the wall") == "Go: 2 m von der Wand, 3 m von der Wand"


def test_what_a_person_wrote_stays_as_it_is():
    translate = Sentences(CATALOGUE).translate
    assert translate("Line 2, open: nothing was there.") == "Zeile 2, open: nichts war da."


def test_an_entry_of_few_letters_fits_numbers_only():
    translate = Sentences(CATALOGUE).translate
    assert translate("0.5 to 3 m") == "0.5 bis 3 m"
    assert translate("go to bed") == "go to bed"


@given(st.lists(WORD, min_size=2, max_size=4), st.data())
def test_a_text_made_of_a_sentence_fits_it(words, data):
    values = [data.draw(WORD) for _ in words[1:]]
    words[-1] += LONG
    text = words[0] + "".join(value + word for value, word in zip(values, words[1:], strict=True))
    found = fit(words, text)
    assert found is not None
    assert words[0] + "".join(v + w for v, w in zip(found, words[1:], strict=True)) == text
    assert all(found)


@given(st.text(max_size=60))
def test_any_text_is_answered_and_english_stays_where_nothing_fits(text):
    assert Sentences({}).translate(text) == text
    assert isinstance(Sentences(CATALOGUE).translate(text), str)


def test_texts_are_read_from_sources_by_their_form():
    source = '''
"""A module with two words."""
def f(x, name):
    """Say nothing here."""
    log.warning("written to a log")
    word, key = "one", "a_key"
    one = gettext("marked already here")
    return f"The {name} is at {x:.1f} mm", "Nothing was done.", "Step %s of many" % x, f"{x} mm", f"Line {x}: {name}."
    on_stage(Progress("docking"))
    return f"it holds {name or 'nothing'}{x}", f"{x} to {name}", f"{x}/key", "SELECT a row"
class State(TextChoices):
    OPEN = "open", "Open"
'''
    assert set(of_source(source)) == {
        "The {name} is at {x} mm", "Nothing was done.", "Step {1} of many", "Line {x}: {name}.", "docking",
        "it holds {value}", "nothing", "{x} to {name}", "Open",
    }  # fmt: skip


def test_errors_between_programs_are_left_out_where_they_are_no_answers():
    source = 'raise ValueError("the bits are none")\nraise BadRequest("That is no number.")'
    assert list(of_source(source)) == ["That is no number."]
    assert set(of_source(source, Path("drivers/srv1/missions.py"))) == {"the bits are none", "That is no number."}


def test_labels_of_packages_are_read_and_names_that_people_write_in_tasks_are_not():
    table = {"tagline": "An arm", "box": [{"name": "the table", "low": [1]}], "path": "a b"}
    assert set(of_table(table)) == {"An arm", "the table"}
    assert set(of_table({"goal": [{"name": "figure", "title": "The figure"}]})) == {"The figure"}


def test_a_spec_gives_the_words_of_its_commands():
    found = set(of_spec(spec_of("mercury")))
    assert {
        "Move",
        "Move to {words}",
        "{number} cm right",
        "{number} m down",
        "Blow air",
        "Blow air for {seconds}",
    } <= found
    assert {"left", "speed {number} m/s", "Raise the camera", "bursts", "theta"} <= found
    assert not {"move", "air", "q1", "x"} & found


def test_the_words_of_an_arms_commands_have_its_plain_words_places_and_shares():
    found = set(of_spec(spec_of("puma")))
    assert {"waist turn {number}°", "waist turn {number}", "{number} % of full speed", "{number} % closed"} <= found
    assert {"{number} cm ahead of the base", "{number} m to its right", "roll {number}°"} <= found
    assert not {"speed {number}", "J1 {number}°"} & found


def test_every_placeholder_of_a_translation_is_in_its_english():
    from babel.messages.pofile import read_po

    for path in sorted(Path("portal/locale").rglob("*.po")):
        with path.open("rb") as file:
            catalogue = read_po(file)
        for message in catalogue:
            ids = message.id if isinstance(message.id, tuple) else (message.id,)
            texts = message.string if isinstance(message.string, tuple) else (message.string,)
            for text in filter(None, texts if message.id else ()):
                assert set(PLACE.findall(text)) <= set(PLACE.findall(ids[-1])), message.id


def test_the_labels_of_a_spec_are_found_also_those_of_one_word_and_no_names():
    burst = Argument("seconds", "s", 0.0, 1.0, required=False)
    commands = (
        CommandKind("air", "Air", (burst,), says="Blow air[ for {seconds}]"),
        CommandKind("go_there", "Go", (Argument("long_way", "m", 0.0, 1.0, directions=("right", "left")),)),
    )
    spec = Spec("Some", commands, modes=("idle", "NO CTRL"))
    assert set(of_spec(spec)) == {
        "Air", "Blow air", "Blow air for {seconds}", "seconds", "seconds {number} s", "Go", "long way", "idle",
        "right", "left", "{number} cm right", "{number} m right", "{number} cm left", "{number} m left",
    }  # fmt: skip


def test_the_labels_of_choices_are_found_marked_or_not():
    source = 'class State(models.TextChoices):\n    A = "a", "Ready"\n    B = "b", gettext_lazy("Moving")\n    C = "c"'
    assert set(of_source(source)) == {"Ready", "Moving"}


if __name__ == "__main__":
    FILE.write_text(json.dumps(vectors(), ensure_ascii=False, indent=1) + "\n")
