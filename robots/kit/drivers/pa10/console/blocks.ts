/** A program's steps as blocks (Blockly); loaded when the program mode is opened. */
import { Blockly, workspace } from "/static/farhand/v1/blocks.js";
import type { Step } from "./program_text.ts";

const POSE = ["x", "y", "z", "roll", "pitch", "yaw"];
type BlockState = {
  type: string;
  fields?: Record<string, unknown>;
  inputs?: Record<string, { block: BlockState }>;
  next?: { block: BlockState };
};

/** A field that shows a number as the text has it: to thousandths, in the bounds of program_text.ts. */
const number = (name: string, low: number, high: number, value = 0, precision = 0.001): object => ({
  type: "field_number",
  name,
  value,
  min: low,
  max: high,
  precision,
});

function define(axes: string[]): void {
  const stacked = { previousStatement: null, nextStatement: null };
  Blockly.common.defineBlocksWithJsonArray([
    {
      ...stacked,
      type: "joints",
      colour: 195,
      tooltip: "Move the six joints (degrees).",
      message0: `joints ${axes
        .slice(0, 3)
        .map((name, i) => `${name} %${i + 1}`)
        .join(" ")}`,
      args0: axes.slice(0, 3).map((name) => number(name, -720, 720)),
      message1: `${axes
        .slice(3)
        .map((name, i) => `${name} %${i + 1}`)
        .join(" ")} speed %${axes.length - 2} %%`,
      args1: [...axes.slice(3).map((name) => number(name, -720, 720)), number("speed", 5, 100, 50, 0.1)],
    },
    {
      ...stacked,
      type: "tool",
      colour: 195,
      tooltip: "Move the tool (mm, degrees).",
      message0: "tool %1 x %2 y %3 z %4",
      args0: [
        {
          type: "field_dropdown",
          name: "path",
          options: [
            ["to", "k"],
            ["straight to", "l"],
          ],
        },
        number("x", -2000, 2000, 500),
        number("y", -2000, 2000),
        number("z", -2000, 2000, 150),
      ],
      message1: "roll %1 pitch %2 yaw %3 speed %4 %%",
      args1: [number("roll", -720, 720, 180), number("pitch", -720, 720), number("yaw", -720, 720, 180), number("speed", 5, 100, 50, 0.1)],
    },
    {
      ...stacked,
      type: "grip",
      colour: 25,
      message0: "gripper %1",
      tooltip: "Open or close the gripper.",
      args0: [
        {
          type: "field_dropdown",
          name: "closed",
          options: [
            ["close", "1"],
            ["open", "0"],
          ],
        },
      ],
    },
    { ...stacked, type: "wait", colour: 60, message0: "wait %1 s", args0: [number("seconds", 0, 30, 1)], tooltip: "Wait so many seconds." },
    {
      ...stacked,
      type: "repeat",
      colour: 130,
      message0: "repeat %1 times %2 %3",
      tooltip: "Repeat the steps inside.",
      args0: [number("times", 1, 100, 2, 1), { type: "input_dummy" }, { type: "input_statement", name: "steps" }],
    },
    {
      ...stacked,
      type: "line",
      colour: 290,
      message0: "line %1",
      args0: [{ type: "field_input", name: "text", text: "" }],
      tooltip: "A line that has no block of its own.",
    },
  ]);
}

export class Blocks {
  private workspace: Blockly.WorkspaceSvg;
  private quiet = false;

  constructor(
    box: HTMLElement,
    private axes: string[],
    changed: (steps: Step[]) => void,
  ) {
    define(axes);
    const categories = [
      { name: "Move", colour: "195", types: ["tool", "joints"] },
      { name: "Gripper", colour: "25", types: ["grip"] },
      { name: "Wait", colour: "60", types: ["wait"] },
      { name: "Repeat", colour: "130", types: ["repeat"] },
    ];
    this.workspace = workspace(box, categories, () => this.quiet || changed(this.steps()));
  }

  /** Show these steps, without reporting a change. */
  show(steps: readonly Step[]): void {
    this.quiet = true;
    const first = this.chain(steps);
    const blocks = first ? { languageVersion: 0, blocks: [{ ...first, x: 24, y: 24 }] } : { languageVersion: 0, blocks: [] };
    Blockly.serialization.workspaces.load({ blocks }, this.workspace);
    setTimeout(() => (this.quiet = false), 50); // Blockly reports changes a moment later
    document.querySelector(".blocklyComputeCanvas")?.setAttribute("aria-hidden", "true"); // it only measures texts
  }

  private chain(steps: readonly Step[]): BlockState | undefined {
    return steps.reduceRight<BlockState | undefined>(
      (next, step) => ({ ...this.block(step), ...(next ? { next: { block: next } } : {}) }),
      undefined,
    );
  }

  private block(step: Step): BlockState {
    const named = (names: string[], values: number[]): object => Object.fromEntries(names.map((name, i) => [name, values[i] ?? 0]));
    const share = (speed?: number): number => Math.round((speed ?? 0.5) * 1000) / 10;
    switch (step.do) {
      case "joints":
        return { type: "joints", fields: { ...named(this.axes, step.values), speed: share(step.speed) } };
      case "pose":
        return { type: "tool", fields: { path: step.straight ? "l" : "k", ...named(POSE, step.values), speed: share(step.speed) } };
      case "grip":
        return { type: "grip", fields: { closed: step.closed ? "1" : "0" } };
      case "wait":
        return { type: "wait", fields: { seconds: step.seconds } };
      case "line":
        return { type: "line", fields: { text: step.text } };
      case "repeat": {
        const inside = this.chain(step.steps);
        return { type: "repeat", fields: { times: step.times }, ...(inside ? { inputs: { steps: { block: inside } } } : {}) };
      }
    }
  }

  private steps(): Step[] {
    return this.workspace.getTopBlocks(true).flatMap((top) => this.from(top));
  }

  private from(block: Blockly.Block | null): Step[] {
    const found: Step[] = [];
    for (let at = block; at; at = at.getNextBlock()) found.push(this.step(at));
    return found;
  }

  private step(block: Blockly.Block): Step {
    const value = (name: string): number => Number(block.getFieldValue(name));
    const speed = value("speed") === 50 ? {} : { speed: value("speed") / 100 };
    switch (block.type) {
      case "joints":
        return { do: "joints", values: this.axes.map(value), ...speed };
      case "tool":
        return { do: "pose", straight: block.getFieldValue("path") === "l", values: POSE.map(value), ...speed };
      case "grip":
        return { do: "grip", closed: block.getFieldValue("closed") === "1" };
      case "wait":
        return { do: "wait", seconds: value("seconds") };
      case "repeat":
        return { do: "repeat", times: value("times"), steps: this.from(block.getInputTargetBlock("steps")) };
      default:
        return { do: "line", text: String(block.getFieldValue("text")) };
    }
  }
}
