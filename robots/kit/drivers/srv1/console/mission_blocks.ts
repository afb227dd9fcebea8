/** A mission's steps as blocks (Blockly); loaded when the mission is edited. */
import { Blockly, workspace } from "/static/farhand/v1/blocks.js";
import type { Floor, Step } from "./mission_text.ts";

const stacked = { previousStatement: null, nextStatement: null };
/** A field that shows a number as the text has it: to thousandths. */
const number = (name: string, low: number, high: number, value: number): object => ({
  type: "field_number",
  name,
  value,
  min: low,
  max: high,
  precision: 0.001,
});

function define(floor: Floor): void {
  const places = floor.node.map(({ name }) => [name, name]);
  Blockly.common.defineBlocksWithJsonArray([
    {
      ...stacked,
      type: "go",
      colour: 195,
      message0: "go to %1",
      args0: [{ type: "field_dropdown", name: "place", options: places }],
      tooltip: "Go to a place of the map.",
    },
    {
      ...stacked,
      type: "spot",
      colour: 195,
      message0: "go to %1 m from the left, %2 m from below",
      args0: [number("x", 0, floor.width, 1), number("y", 0, floor.depth, 1)],
      tooltip: "Go to any place of the hall.",
    },
    {
      ...stacked,
      type: "turn",
      colour: 195,
      message0: "turn %1 degrees to the left",
      args0: [number("degrees", -360, 360, 90)],
      tooltip: "Turn in place.",
    },
    { ...stacked, type: "look", colour: 25, message0: "look around", tooltip: "Turn once, and measure in 18 directions." },
    { ...stacked, type: "photograph", colour: 25, message0: "photograph", tooltip: "Take a picture that is kept." },
    { ...stacked, type: "read", colour: 25, message0: "read the sensors", tooltip: "Note what the sensors measure." },
    { ...stacked, type: "wait", colour: 60, message0: "wait %1 s", args0: [number("seconds", 0, 120, 5)], tooltip: "Stay there." },
    {
      ...stacked,
      type: "patrol",
      colour: 130,
      message0: "patrol %1 s",
      args0: [number("seconds", 1, 120, 30)],
      tooltip: "Drive by the rules.",
    },
    {
      ...stacked,
      type: "say",
      colour: 290,
      message0: "say %1",
      args0: [{ type: "field_input", name: "words", text: "Here I am." }],
      tooltip: "Write words into what it found.",
    },
  ]);
}

export class MissionBlocks {
  private workspace: Blockly.WorkspaceSvg;
  private quiet = false;

  constructor(
    box: HTMLElement,
    private floor: Floor,
    changed: (steps: Step[]) => void,
  ) {
    define(floor);
    const categories = [
      { name: "Drive", colour: "195", types: ["go", "spot", "turn"] },
      { name: "Find out", colour: "25", types: ["photograph", "read", "look"] },
      { name: "Wait", colour: "60", types: ["wait"] },
      { name: "Patrol", colour: "130", types: ["patrol"] },
      { name: "Say", colour: "290", types: ["say"] },
    ];
    this.workspace = workspace(box, categories, () => this.quiet || changed(this.steps()));
  }

  /** Show these steps, without reporting a change. */
  show(steps: readonly Step[]): void {
    this.quiet = true;
    const first = steps.reduceRight<object | undefined>(
      (next, step) => ({ ...block(step), ...(next ? { next: { block: next } } : {}) }),
      undefined,
    );
    const blocks = { languageVersion: 0, blocks: first ? [{ ...first, x: 24, y: 24 }] : [] };
    Blockly.serialization.workspaces.load({ blocks }, this.workspace);
    setTimeout(() => (this.quiet = false), 50); // Blockly reports changes a moment later
    document.querySelector(".blocklyComputeCanvas")?.setAttribute("aria-hidden", "true"); // it only measures texts
  }

  private steps(): Step[] {
    const found: Step[] = [];
    for (const top of this.workspace.getTopBlocks(true))
      for (let at: Blockly.Block | null = top; at; at = at.getNextBlock()) found.push(this.step(at));
    return found;
  }

  private step(block: Blockly.Block): Step {
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
}

function block(step: Step): { type: string; fields?: Record<string, unknown> } {
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
