/** A mission's steps as blocks (Blockly); loaded when the mission is edited. */
import { type Blockly, type BlockState, choiceField, defineStep, numberField, StepWorkspace } from "/static/farhand/v1/blocks.js";
import type { Floor, Step } from "./mission_text.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

const CATEGORIES = [
  { name: gettext("Drive"), colour: "195", types: ["go", "spot", "turn"] },
  { name: gettext("Find out"), colour: "25", types: ["photograph", "read", "look"] },
  { name: gettext("Wait"), colour: "60", types: ["wait"] },
  { name: gettext("Patrol"), colour: "130", types: ["patrol"] },
  { name: gettext("Say"), colour: "290", types: ["say"] },
];

function define({ node, width, depth }: Floor): void {
  const places = node.map(({ name }): [string, string] => [translate(name), name]);
  const [x, y] = [numberField("x", 0, width, 1), numberField("y", 0, depth, 1)];
  defineStep("go", 195, gettext("Go to a place of the map."), gettext("go to %1"), [choiceField("place", places)]);
  defineStep("spot", 195, gettext("Go to any place of the hall."), gettext("go to %1 m from the left, %2 m from below"), [x, y]);
  defineStep("turn", 195, gettext("Turn in place."), gettext("turn %1 degrees to the left"), [numberField("degrees", -360, 360, 90)]);
  defineStep("look", 25, gettext("Turn once, and measure in 18 directions."), gettext("look around"));
  defineStep("photograph", 25, gettext("Take a picture that is kept."), gettext("photograph"));
  defineStep("read", 25, gettext("Note what the sensors measure."), gettext("read the sensors"));
  defineStep("wait", 60, gettext("Stay there."), gettext("wait %1 s"), [numberField("seconds", 0, 120, 5)]);
  defineStep("patrol", 130, gettext("Drive by the rules."), gettext("patrol %1 s"), [numberField("seconds", 1, 120, 30)]);
  defineStep("say", 290, gettext("Write words into what it found."), gettext("say %1"), [
    { type: "field_input", name: "words", text: gettext("Here I am.") },
  ]);
}

export class MissionBlocks extends StepWorkspace<Step> {
  constructor(
    box: HTMLElement,
    private floor: Floor,
    changed: (steps: Step[]) => void,
  ) {
    define(floor);
    super(box, CATEGORIES, changed);
  }

  protected override step(block: Blockly.Block): Step {
    const value = (name: string): number => Number(block.getFieldValue(name));
    switch (block.type) {
      case "go": {
        const node = this.floor.node.find(({ name }) => name === block.getFieldValue("place"));
        return { do: "go", name: node?.name ?? "", x: node?.at[0] ?? 0, y: node?.at[1] ?? 0 };
      }
      case "spot":
        return { do: "go", name: "", x: value("x"), y: value("y") };
      case "turn":
        return { do: "turn", degrees: value("degrees") };
      case "wait":
      case "patrol":
        return { do: block.type, seconds: value("seconds") };
      case "say":
        return { do: "say", words: String(block.getFieldValue("words")).trim() || "…" };
      default:
        return { do: block.type as "look" | "photograph" | "read" };
    }
  }

  protected override block(step: Step): BlockState {
    switch (step.do) {
      case "go":
        return step.name ? { type: "go", fields: { place: step.name } } : { type: "spot", fields: { x: step.x, y: step.y } };
      case "turn":
        return { type: "turn", fields: { degrees: step.degrees } };
      case "wait":
      case "patrol":
        return { type: step.do, fields: { seconds: step.seconds } };
      case "say":
        return { type: "say", fields: { words: step.words } };
      default:
        return { type: step.do };
    }
  }
}
