/** A program's steps as blocks (Blockly); loaded when the program mode is opened. */
import { type Blockly, type BlockState, choiceField, defineStep, numberField, StepWorkspace } from "/static/farhand/v1/blocks.js";
import type { Step } from "./program_text.ts";
import { gettext, translate } from "/static/farhand/v1/text.js";

const POSE = ["x", "y", "z", "roll", "pitch", "yaw"];
const CATEGORIES = [
  { name: gettext("Move"), colour: "195", types: ["tool", "joints"] },
  { name: gettext("Gripper"), colour: "25", types: ["grip"] },
  { name: gettext("Wait"), colour: "60", types: ["wait"] },
  { name: gettext("Repeat"), colour: "130", types: ["repeat"] },
];

function define(axes: string[]): void {
  const angles = (names: string[]): object[] => names.map((name) => numberField(name, -720, 720));
  const row = (names: string[]): string => names.map((name, i) => `${translate(name)} %${i + 1}`).join(" ");
  const speed = numberField("speed", 5, 100, 50, 0.1);
  const [first, last] = [axes.slice(0, 3), axes.slice(3)];
  defineStep("joints", 195, gettext("Move the six joints (degrees)."), `${gettext("joints")} ${row(first)}`, angles(first), {
    message1: `${row([...last, "speed"])} %%`,
    args1: [...angles(last), speed],
  });
  const path = choiceField("path", [
    [gettext("to"), "k"],
    [gettext("straight to"), "l"],
  ]);
  const place = [numberField("x", -2000, 2000, 500), numberField("y", -2000, 2000), numberField("z", -2000, 2000, 150)];
  defineStep("tool", 195, gettext("Move the tool (mm, degrees)."), gettext("tool %1 x %2 y %3 z %4"), [path, ...place], {
    message1: gettext("roll %1 pitch %2 yaw %3 speed %4 %%"),
    args1: [numberField("roll", -720, 720, 180), numberField("pitch", -720, 720), numberField("yaw", -720, 720, 180), speed],
  });
  const closed = choiceField("closed", [
    [gettext("close"), "1"],
    [gettext("open"), "0"],
  ]);
  defineStep("grip", 25, gettext("Open or close the gripper."), gettext("gripper %1"), [closed]);
  defineStep("wait", 60, gettext("Wait so many seconds."), gettext("wait %1 s"), [numberField("seconds", 0, 30, 1)]);
  const inside = [numberField("times", 1, 100, 2, 1), { type: "input_dummy" }, { type: "input_statement", name: "steps" }];
  defineStep("repeat", 130, gettext("Repeat the steps inside."), gettext("repeat %1 times %2 %3"), inside);
  defineStep("line", 290, gettext("A line that has no block of its own."), gettext("line %1"), [
    { type: "field_input", name: "text", text: "" },
  ]);
}

export class Blocks extends StepWorkspace<Step> {
  constructor(
    box: HTMLElement,
    private axes: string[],
    changed: (steps: Step[]) => void,
  ) {
    define(axes);
    super(box, CATEGORIES, changed);
  }

  protected override block(step: Step): BlockState {
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

  protected override step(block: Blockly.Block): Step {
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
        return { do: "repeat", times: value("times"), steps: this.stepsFrom(block.getInputTargetBlock("steps")) };
      default:
        return { do: "line", text: String(block.getFieldValue("text")) };
    }
  }
}
