/** The buttons of an arm's console, and as what each is judged. */

/** The kind of command of each button, as `whyNot` judges it. */
export const BUTTONS = {
  open: "gripper",
  close: "gripper",
  ready: "ready",
  "go-joints": "go",
  "go-pose": "go",
  "send-ghost": "go",
  "run-task": "run-task",
  run: "run",
  "pick-here": "pick-here",
  "put-here": "put-here",
  "go-pick": "go-pick",
};
/** The kinds that choose and send a place in a picture. */
export const PICKING: ReadonlySet<string> = new Set(["pick-here", "put-here", "go-pick"]);
