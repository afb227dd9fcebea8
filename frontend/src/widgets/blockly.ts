/** Blockly under our content policy and in our colours; a robot's console brings the blocks of its language. */
import * as Blockly from "blockly/core";
import * as en from "blockly/msg/en";

export { Blockly };

/* eslint-disable @typescript-eslint/unbound-method, @typescript-eslint/no-deprecated -- `createElement` itself is replaced for a while */
/** Blockly writes `<style>` elements, which the page's content policy forbids; its rules are added as adopted style sheets instead. */
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

export interface Category {
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

Blockly.setLocale(en as unknown as Record<string, string>);
