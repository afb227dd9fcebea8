/** The admin's editor of forbidden boxes: a table beside the arm in three dimensions, over the field that is sent. */
import "../../arm/arm.css";
import type { ArmDescription } from "../../arm/types.ts";
import { ArmView, type ForbiddenBox } from "../../arm/view.ts";
import { make } from "../../kit/dom.ts";
import { FILE_MS, request } from "../../kit/request.ts";
import { gettext } from "../../kit/text.ts";

interface Facts extends ArmDescription {
  posture: number[];
}
const CORNERS = [
  gettext("from x (m)"),
  gettext("from y (m)"),
  gettext("from z (m)"),
  gettext("to x (m)"),
  gettext("to y (m)"),
  gettext("to z (m)"),
];

/** Put the editor before the text field, which stays for people who prefer to write. */
export async function edit(field: HTMLTextAreaElement, told: unknown): Promise<void> {
  const facts = told as Facts;
  const holder = make("div", { class: "model" }),
    rows = make("div"),
    add = make("button", { type: "button" }, gettext("Add a box"));
  field.before(make("div", { class: "boxes-editor" }, holder, rows, add));
  const view = await preview(holder, facts);
  let boxes: ForbiddenBox[] = [];

  const read = (): void => {
    try {
      boxes = JSON.parse(field.value || "[]") as ForbiddenBox[];
      rows.replaceChildren(...boxes.map((one, i) => row(one, i)));
      show();
    } catch {
      rows.textContent = gettext("The text below is not a list of boxes.");
    }
  };
  const show = (): void => view?.boxes([...facts.boxes, ...boxes.filter((b) => [...b.low, ...b.high].every(Number.isFinite))]);
  const write = (): void => {
    field.value = JSON.stringify(boxes);
    show();
  };
  const row = (one: ForbiddenBox, index: number): HTMLElement => {
    const name = labelled(gettext("name"), "text", one.name, (value) => {
      one.name = value;
      write();
    });
    const corners = CORNERS.map((label, k) =>
      labelled(label, "number", String((k < 3 ? one.low : one.high)[k % 3] ?? 0), (value) => {
        (k < 3 ? one.low : one.high)[k % 3] = Number(value);
        write();
      }),
    );
    const remove = make("button", { type: "button" }, gettext("Remove {name}", { name: one.name }));
    remove.addEventListener("click", () => {
      boxes.splice(index, 1);
      write();
      read();
    });
    return make("fieldset", {}, make("legend", {}, gettext("Box {number}", { number: index + 1 })), name, ...corners, remove);
  };
  add.addEventListener("click", () => {
    boxes.push({ name: `box ${boxes.length + 1}`, low: [0.4, 0.3, 0], high: [0.6, 0.5, 0.3] });
    write();
    read();
  });
  field.addEventListener("change", read);
  read();
}

async function preview(holder: HTMLElement, facts: Facts): Promise<ArmView | null> {
  try {
    const answer = await request(facts.model, {}, FILE_MS);
    const names = facts.joints.map((j) => [j.name]);
    const view = new ArmView(holder, await answer.text(), names, facts.tip, facts.boxes, () => undefined);
    view.joints(facts.posture);
    return view;
  } catch (error) {
    holder.remove();
    console.warn(error);
    return null;
  }
}

function labelled(words: string, type: string, value: string, changed: (value: string) => void): HTMLElement {
  const input = make("input", { type, value, step: "any" });
  input.addEventListener("input", () => changed(input.value));
  return make("label", {}, words, input);
}
