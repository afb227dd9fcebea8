/** Blockly under our content policy and in our colours; a robot's console brings the blocks of its language. */
import * as Blockly from "blockly/core";
import * as en from "blockly/msg/en";
import { isRightToLeft } from "../kit/dom.ts";
import { language } from "../kit/text.ts";

export { Blockly };

/* eslint-disable @typescript-eslint/unbound-method, @typescript-eslint/no-deprecated -- `createElement` itself is replaced for a while */
/** Run `run`, and add the rules of the `<style>` elements that Blockly writes, which the content policy forbids, as style sheets. */
function adopting<T>(run: () => T): T {
  const make = document.createElement;
  const made: HTMLElement[] = [];
  document.createElement = (name: string, options?: ElementCreationOptions) => {
    const element = make.call(document, name.toLowerCase() === "style" ? "blockly-rules" : name, options);
    if (name.toLowerCase() === "style") made.push(element);
    return element;
  };
  try {
    return run();
  } finally {
    document.createElement = make;
    for (const element of made) {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync(element.textContent);
      document.adoptedStyleSheets.push(sheet);
      element.remove();
    }
  }
}

/* eslint-enable @typescript-eslint/unbound-method, @typescript-eslint/no-deprecated */

/** The page's own colours, which follow its scheme by themselves. */
const THEME = Blockly.Theme.defineTheme("farhand", {
  name: "farhand",
  base: Blockly.Themes.Zelos,
  componentStyles: {
    workspaceBackgroundColour: "var(--card)",
    toolboxBackgroundColour: "var(--paper)",
    toolboxForegroundColour: "var(--ink)",
    flyoutBackgroundColour: "var(--paper)",
    flyoutForegroundColour: "var(--ink)",
    flyoutOpacity: 0.97,
    scrollbarColour: "var(--quiet)",
    scrollbarOpacity: 0.6,
  },
});

interface Category {
  name: string;
  colour: string;
  types: string[];
}

/** Open a workspace in the box; its block types must be defined. `changed` is called when a person changed a block. */
export function workspace(box: HTMLElement, categories: Category[], changed: () => void): Blockly.WorkspaceSvg {
  const contents = categories.map(({ name, colour, types }) => ({
    kind: "category",
    name,
    colour,
    contents: types.map((type) => ({ kind: "block", type })),
  }));
  const made = adopting(() =>
    Blockly.inject(box, {
      toolbox: { kind: "categoryToolbox", contents } as Blockly.utils.toolbox.ToolboxDefinition,
      trashcan: false,
      sounds: false,
      modalInputs: false,
      rtl: isRightToLeft(box),
      theme: THEME,
      scrollbars: true,
      horizontalLayout: true,
      renderer: "zelos",
      zoom: { startScale: 0.75, controls: false, wheel: false },
      move: { scrollbars: true, drag: true, wheel: false },
    }),
  );
  made.addChangeListener((event) => {
    // eslint-disable-next-line @typescript-eslint/no-unsafe-enum-comparison -- Blockly declares the type of an event as a text
    if (!event.isUiEvent && event.type !== Blockly.Events.FINISHED_LOADING && !made.isDragging()) changed();
  });
  new ResizeObserver(() => Blockly.svgResize(made)).observe(box);
  return made;
}

type Messages = Record<string, string>;
/** Blockly's own words in languages other than English. */
const MESSAGES: Readonly<Record<string, () => Promise<unknown>>> = { de: () => import("blockly/msg/de") };

const messages = await MESSAGES[language()]?.().catch(() => null); // in English rather than not at all
Blockly.setLocale((messages ?? en) as Messages);

/** A block as Blockly stores it. */
export interface BlockState {
  type: string;
  fields?: Record<string, unknown>;
  inputs?: Record<string, { block: BlockState }>;
  next?: { block: BlockState };
}

/** The steps of a program as blocks; a subclass says which block stands for which step. */
export abstract class StepWorkspace<Step> {
  private workspace: Blockly.WorkspaceSvg;
  private quiet = false;

  /** `changed` gets the steps when a person has changed a block. The block types must be defined. */
  constructor(box: HTMLElement, categories: Category[], changed: (steps: Step[]) => void) {
    this.workspace = workspace(box, categories, () => {
      if (!this.quiet) changed(this.workspace.getTopBlocks(true).flatMap((top) => this.stepsFrom(top)));
    });
  }

  protected abstract block(step: Step): BlockState;
  protected abstract step(block: Blockly.Block): Step;

  /** Show these steps, without reporting a change. */
  show(steps: readonly Step[]): void {
    this.quiet = true;
    const first = this.chain(steps);
    const blocks = { languageVersion: 0, blocks: first ? [{ ...first, x: 24, y: 24 }] : [] };
    Blockly.serialization.workspaces.load({ blocks }, this.workspace);
    setTimeout(() => (this.quiet = false), 50); // Blockly reports changes a moment later
    document.querySelector(".blocklyComputeCanvas")?.setAttribute("aria-hidden", "true"); // it only measures texts
  }

  /** Return the blocks of these steps, each fixed below the one before; undefined for none. */
  protected chain(steps: readonly Step[]): BlockState | undefined {
    const below = (next: BlockState | undefined, step: Step): BlockState => ({
      ...this.block(step),
      ...(next ? { next: { block: next } } : {}),
    });
    return steps.reduceRight<BlockState | undefined>(below, undefined);
  }

  /** Return the steps of a block and of those below it. */
  protected stepsFrom(block: Blockly.Block | null): Step[] {
    const steps: Step[] = [];
    for (let at = block; at; at = at.getNextBlock()) steps.push(this.step(at));
    return steps;
  }
}

/** Define a type of block that stands for a step. `message0` has %1, %2 and so on for its fields; `more`: further rows. */
export function defineStep(type: string, colour: number, tooltip: string, message0: string, args0: object[] = [], more: object = {}): void {
  const stacked = { previousStatement: null, nextStatement: null };
  Blockly.common.defineBlocksWithJsonArray([{ ...stacked, type, colour, tooltip, message0, args0, ...more }]);
}

/** Return a field of a block for a number, to thousandths as in texts. */
export function numberField(name: string, min: number, max: number, value = 0, precision = 0.001): object {
  return { type: "field_number", name, value, min, max, precision };
}

/** Return a field of a block for a choice; each option has a text and a value. */
export function choiceField(name: string, options: [text: string, value: string][]): object {
  return { type: "field_dropdown", name, options };
}
