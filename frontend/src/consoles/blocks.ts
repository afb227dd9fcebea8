/** A program's steps as blocks (Blockly); loaded when the program mode is opened. */
import * as Blockly from "blockly/core";
import * as en from "blockly/msg/en";
import type { Step } from "./program_text.ts";

const HAND = ["x", "y", "z", "roll", "pitch", "yaw"];
type BlockState = { type: string; fields?: Record<string, unknown>; inputs?: Record<string, { block: BlockState }>; next?: { block: BlockState } };

const number = (name: string, low: number, high: number, value = 0, precision = 0.1): object => ({
  type: "field_number", name, value, min: low, max: high, precision,
});

function define(axes: string[]): void {
  const stacked = { previousStatement: null, nextStatement: null };
  Blockly.common.defineBlocksWithJsonArray([
    {
      ...stacked, type: "joints", colour: 195, tooltip: "Move the six joints (degrees).",
      message0: `joints ${axes.slice(0, 3).map((name, i) => `${name} %${i + 1}`).join(" ")}`,
      args0: axes.slice(0, 3).map((name) => number(name, -270, 270)),
      message1: `${axes.slice(3).map((name, i) => `${name} %${i + 1}`).join(" ")} speed %${axes.length - 2} %%`,
      args1: [...axes.slice(3).map((name) => number(name, -270, 270)), number("speed", 5, 100, 50, 5)],
    },
    {
      ...stacked, type: "hand", colour: 195, tooltip: "Move the hand (mm, degrees).",
      message0: "hand %1 x %2 y %3 z %4",
      args0: [
        { type: "field_dropdown", name: "path", options: [["to", "k"], ["straight to", "l"]] },
        number("x", -1600, 1600, 500), number("y", -1600, 1600), number("z", -1600, 1600, 150),
      ],
      message1: "roll %1 pitch %2 yaw %3 speed %4 %%",
      args1: [number("roll", -360, 360, 180), number("pitch", -360, 360), number("yaw", -360, 360, 180), number("speed", 5, 100, 50, 5)],
    },
    {
      ...stacked, type: "grip", colour: 25, message0: "gripper %1", tooltip: "Open or close the gripper.",
      args0: [{ type: "field_dropdown", name: "closed", options: [["close", "1"], ["open", "0"]] }],
    },
    { ...stacked, type: "wait", colour: 60, message0: "wait %1 s", args0: [number("seconds", 0, 30, 1)], tooltip: "Wait so many seconds." },
    {
      ...stacked, type: "repeat", colour: 130, message0: "repeat %1 times %2 %3", tooltip: "Do the steps inside again and again.",
      args0: [number("times", 1, 100, 2, 1), { type: "input_dummy" }, { type: "input_statement", name: "steps" }],
    },
    { ...stacked, type: "line", colour: 290, message0: "line %1", args0: [{ type: "field_input", name: "text", text: "" }], tooltip: "A line that has no block of its own." },
  ]);
}

/** Blockly writes `<style>` elements, which the page's content policy forbids; its rules are adopted instead. */
function adopting<T>(run: () => T): T {
  const make = document.createElement;
  const made: HTMLElement[] = [];
  document.createElement = ((name: string, options?: ElementCreationOptions) => {
    const element = make.call(document, name.toLowerCase() === "style" ? "blockly-rules" : name, options);
    if (name.toLowerCase() === "style") made.push(element);
    return element;
  }) as typeof document.createElement;
  try {
    return run();
  } finally {
    document.createElement = make;
    for (const element of made) {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync(element.textContent ?? "");
      document.adoptedStyleSheets.push(sheet);
      element.remove();
    }
  }
}

/** The page's own colours, which follow its scheme by themselves. */
const THEME = Blockly.Theme.defineTheme("farhand", {
  name: "farhand",
  base: Blockly.Themes.Zelos,
  componentStyles: {
    workspaceBackgroundColour: "var(--card)", toolboxBackgroundColour: "var(--paper)", toolboxForegroundColour: "var(--ink)",
    flyoutBackgroundColour: "var(--paper)", flyoutForegroundColour: "var(--ink)", flyoutOpacity: 0.97,
    scrollbarColour: "var(--quiet)", scrollbarOpacity: 0.6,
  },
});

export class Blocks {
  private workspace: Blockly.WorkspaceSvg;
  private quiet = false;

  constructor(box: HTMLElement, private axes: string[], changed: (steps: Step[]) => void) {
    Blockly.setLocale(en as unknown as Record<string, string>);
    define(axes);
    const category = (name: string, colour: string, types: string[]): object => ({
      kind: "category", name, colour, contents: types.map((type) => ({ kind: "block", type })),
    });
    this.workspace = adopting(() =>
      Blockly.inject(box, {
        toolbox: {
          kind: "categoryToolbox",
          contents: [category("Move", "195", ["hand", "joints"]), category("Gripper", "25", ["grip"]), category("Wait", "60", ["wait"]), category("Repeat", "130", ["repeat"])],
        } as Blockly.utils.toolbox.ToolboxDefinition,
        trashcan: false, sounds: false, modalInputs: false, theme: THEME, scrollbars: true, horizontalLayout: true, renderer: "zelos",
        zoom: { startScale: 0.75, controls: false, wheel: false }, move: { scrollbars: true, drag: true, wheel: false },
      }),
    );
    this.workspace.addChangeListener((event) => {
      if (!this.quiet && !event.isUiEvent && event.type !== Blockly.Events.FINISHED_LOADING && !this.workspace.isDragging()) changed(this.steps());
    });
    new ResizeObserver(() => Blockly.svgResize(this.workspace)).observe(box);
  }

  /** Show these steps, without telling of a change. */
  show(steps: Step[]): void {
    this.quiet = true;
    const first = this.chain(steps);
    const blocks = first ? { languageVersion: 0, blocks: [{ ...first, x: 24, y: 24 }] } : { languageVersion: 0, blocks: [] };
    Blockly.serialization.workspaces.load({ blocks }, this.workspace);
    setTimeout(() => (this.quiet = false), 50); // Blockly tells of changes a moment later
    document.querySelector(".blocklyComputeCanvas")?.setAttribute("aria-hidden", "true"); // it only measures texts
  }

  private chain(steps: Step[]): BlockState | undefined {
    return steps.reduceRight<BlockState | undefined>(
      (next, step) => ({ ...this.block(step), ...(next ? { next: { block: next } } : {}) }), undefined,
    );
  }

  private block(step: Step): BlockState {
    const named = (names: string[], values: number[]): object => Object.fromEntries(names.map((name, i) => [name, values[i] ?? 0]));
    const share = (speed?: number): number => Math.round((speed ?? 0.5) * 100);
    switch (step.do) {
      case "joints": return { type: "joints", fields: { ...named(this.axes, step.values), speed: share(step.speed) } };
      case "hand": return { type: "hand", fields: { path: step.straight ? "l" : "k", ...named(HAND, step.values), speed: share(step.speed) } };
      case "grip": return { type: "grip", fields: { closed: step.closed ? "1" : "0" } };
      case "wait": return { type: "wait", fields: { seconds: step.seconds } };
      case "line": return { type: "line", fields: { text: step.text } };
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
      case "joints": return { do: "joints", values: this.axes.map(value), ...speed };
      case "hand": return { do: "hand", straight: block.getFieldValue("path") === "l", values: HAND.map(value), ...speed };
      case "grip": return { do: "grip", closed: block.getFieldValue("closed") === "1" };
      case "wait": return { do: "wait", seconds: value("seconds") };
      case "repeat": return { do: "repeat", times: value("times"), steps: this.from(block.getInputTargetBlock("steps")) };
      default: return { do: "line", text: String(block.getFieldValue("text")) };
    }
  }
}
