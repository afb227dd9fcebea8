/** The blocks of tasks (Blockly), for every arm with objects; loaded by `import()` when its mode is opened. */
import { type Blockly, type BlockState, choiceField, defineStep, numberField, StepWorkspace } from "./blockly.ts";
import { PLATE, printTask, type TaskStep } from "./task_text.ts";
import { gettext, translate } from "../kit/text.ts";

const TABLE = "table";
const CATEGORIES = [
  { name: gettext("Objects"), colour: "25", types: ["task-grasp", "task-on", "task-at", "task-stud"] },
  { name: gettext("Move"), colour: "195", types: ["task-move", "task-posture", "task-hand"] },
  { name: gettext("Wait"), colour: "60", types: ["task-wait"] },
  { name: gettext("Expect"), colour: "290", types: ["task-lies", "task-holds", "task-empty"] },
  { name: gettext("Repeat"), colour: "130", types: ["task-repeat"] },
];

/** Define the blocks for these objects and named postures. */
function define(names: readonly string[], postures: readonly string[], surfaces: readonly string[]): void {
  const choice = (field: string, of: readonly string[]): object =>
    choiceField(
      field,
      of.map((name) => [translate(name), name]),
    );
  const mm = (field: string, value = 0): object => numberField(field, -3000, 3000, value),
    degrees = (field: string): object => numberField(field, -360, 360);
  const thing = choice("name", names);
  defineStep("task-grasp", 25, gettext("Take an object."), gettext("grasp %1"), [thing]);
  defineStep(
    "task-on",
    25,
    gettext("Put an object on another one; take it first if the gripper is empty."),
    gettext("put %1 on %2"),
    [thing, choice("on", [...names, ...surfaces])],
    {
      message1: gettext("moved by %1 %2 mm, turned %3 °"),
      args1: [mm("dx"), mm("dy"), degrees("turned")],
    },
  );
  defineStep("task-at", 25, gettext("Put an object on the table (mm)."), gettext("put %1 at x %2 y %3"), [thing, mm("x", 450), mm("y")]);
  const stud = (field: string): object => numberField(field, 1, 99, 1, 1);
  defineStep(
    "task-stud",
    25,
    gettext("Press an object onto the plate, with its corner on a stud."),
    gettext("put %1 on plate at column %2 row %3 turned %4 °"),
    [thing, stud("column"), stud("row"), degrees("turned")],
  );
  defineStep("task-move", 195, gettext("Move the tool (mm); it keeps its rotation."), gettext("move to x %1 y %2 z %3"), [
    mm("x", 450),
    mm("y"),
    mm("z", 250),
  ]);
  defineStep("task-posture", 195, gettext("Move the arm to a posture that has a name."), gettext("move to %1"), [
    choice("posture", postures),
  ]);
  defineStep("task-hand", 195, gettext("Open or close the gripper."), gettext("%1 the gripper"), [
    choiceField("do", [
      [gettext("open"), "open"],
      [gettext("close"), "close"],
    ]),
  ]);
  defineStep("task-wait", 60, gettext("Wait so many seconds."), gettext("wait %1 s"), [numberField("seconds", 0, 30, 1)]);
  defineStep("task-lies", 290, gettext("Go on only if it is so."), gettext("expect %1 on %2"), [
    thing,
    choice("on", [...names, TABLE, ...surfaces]),
  ]);
  defineStep("task-holds", 290, gettext("Go on only if it is so."), gettext("expect to hold %1"), [thing]);
  defineStep("task-empty", 290, gettext("Go on only if it is so."), gettext("expect an empty gripper"));
  const inside = [numberField("times", 1, 100, 2, 1), { type: "input_dummy" }, { type: "input_statement", name: "steps" }];
  defineStep("task-repeat", 130, gettext("Repeat the steps inside."), gettext("repeat %1 times %2 %3"), inside);
  defineStep("task-line", 290, gettext("A line that has no block of its own."), gettext("line %1"), [
    { type: "field_input", name: "text", text: "" },
  ]);
}

export class TaskBlocks extends StepWorkspace<TaskStep> {
  constructor(
    box: HTMLElement,
    private names: readonly string[],
    private postures: readonly string[],
    private hasPlate: boolean,
    changed: (steps: TaskStep[]) => void,
  ) {
    define(names, postures, hasPlate ? [PLATE] : []);
    super(
      box,
      hasPlate ? CATEGORIES : CATEGORIES.map((one) => ({ ...one, types: one.types.filter((type) => type !== "task-stud") })),
      changed,
    );
  }

  protected override block(step: TaskStep): BlockState {
    if (step.do === "repeat") {
      const inside = this.chain(step.steps);
      return { type: "task-repeat", fields: { times: step.times }, ...(inside ? { inputs: { steps: { block: inside } } } : {}) };
    }
    return this.own(step) ?? { type: "task-line", fields: { text: printTask([step]) } };
  }

  /** Return the block of a step; null for one with a name or a value that its block does not have. */
  private own(step: TaskStep): BlockState | null {
    const known = (...names: string[]): boolean => names.every((name) => this.names.includes(name));
    switch (step.do) {
      case "grasp":
        return known(step.name) ? { type: "task-grasp", fields: { name: step.name } } : null;
      case "on": {
        const [dx = 0, dy = 0] = step.by ?? [],
          [column, row] = step.stud ?? [];
        if (step.stud && this.hasPlate && known(step.name))
          return { type: "task-stud", fields: { name: step.name, column, row, turned: step.turned ?? 0 } };
        if (step.stud) return null;
        const fields = { name: step.name, on: step.on, dx, dy, turned: step.turned ?? 0 };
        return known(step.name) && this.bears(step.on) ? { type: "task-on", fields } : null;
      }
      case "at":
        if (step.yaw !== undefined || !known(step.name)) return null;
        return { type: "task-at", fields: { name: step.name, x: step.at[0], y: step.at[1] } };
      case "move":
        if (step.angles) return null;
        return { type: "task-move", fields: { x: step.place[0], y: step.place[1], z: step.place[2] } };
      case "posture":
        return this.postures.includes(step.posture) ? { type: "task-posture", fields: { posture: step.posture } } : null;
      case "open":
      case "close":
        return { type: "task-hand", fields: { do: step.do } };
      case "wait":
        return { type: "task-wait", fields: { seconds: step.seconds } };
      case "lies":
        if (!known(step.name) || (step.on !== TABLE && !this.bears(step.on))) return null;
        return { type: "task-lies", fields: { name: step.name, on: step.on } };
      case "holds":
        if (step.name === null) return { type: "task-empty" };
        return known(step.name) ? { type: "task-holds", fields: { name: step.name } } : null;
      default:
        return null;
    }
  }

  private bears(name: string): boolean {
    return this.names.includes(name) || (this.hasPlate && name === PLATE);
  }

  protected override step(block: Blockly.Block): TaskStep {
    const text = (field: string): string => String(block.getFieldValue(field)),
      value = (field: string): number => Number(block.getFieldValue(field));
    switch (block.type) {
      case "task-grasp":
        return { do: "grasp", name: text("name") };
      case "task-on": {
        const by = [value("dx"), value("dy")],
          turned = value("turned");
        return { do: "on", name: text("name"), on: text("on"), ...(by.some(Boolean) ? { by } : {}), ...(turned ? { turned } : {}) };
      }
      case "task-stud": {
        const turned = value("turned");
        return { do: "on", name: text("name"), on: PLATE, stud: [value("column"), value("row")], ...(turned ? { turned } : {}) };
      }
      case "task-at":
        return { do: "at", name: text("name"), at: [value("x"), value("y")] };
      case "task-move":
        return { do: "move", place: [value("x"), value("y"), value("z")] };
      case "task-posture":
        return { do: "posture", posture: text("posture") };
      case "task-hand":
        return { do: text("do") === "close" ? "close" : "open" };
      case "task-wait":
        return { do: "wait", seconds: value("seconds") };
      case "task-lies":
        return { do: "lies", name: text("name"), on: text("on") };
      case "task-holds":
        return { do: "holds", name: text("name") };
      case "task-empty":
        return { do: "holds", name: null };
      case "task-repeat":
        return { do: "repeat", times: value("times"), steps: this.stepsFrom(block.getInputTargetBlock("steps")) };
      default:
        return { do: "line", text: text("text") };
    }
  }
}
