/** The admin's robot page: live status without a reload. */
import "./admin.css";
import { morph } from "../kit/morph.ts";
import { every } from "../kit/page_clock.ts";
import { request } from "../kit/request.ts";

const box = document.querySelector<HTMLElement>("[data-status-url]");
async function refresh(): Promise<void> {
  if (!box || document.hidden) return;
  try {
    const answer = await request(box.dataset["statusUrl"] ?? "", { headers: { Accept: "text/html" } });
    if (answer.ok) {
      const fresh = new DOMParser().parseFromString(await answer.text(), "text/html");
      const next = box.cloneNode() as HTMLElement;
      next.replaceChildren(...fresh.body.childNodes);
      delete next.dataset["stale"];
      morph(box, next);
    }
  } catch {
    box.dataset["stale"] = "true";
  }
}
if (box) every(2000, () => void refresh());

const facts = document.getElementById("model-facts");
interface Editor {
  edit: (field: HTMLTextAreaElement, facts: unknown) => Promise<void>;
}
const editors = import.meta.glob<Editor>("./editors/*.ts"); // by the names that settings give
for (const field of facts ? document.querySelectorAll<HTMLTextAreaElement>("textarea[data-editor]") : [])
  void editors[`./editors/${field.dataset["editor"]}.ts`]?.().then(({ edit }) =>
    edit(field, JSON.parse(facts?.textContent ?? "{}") as unknown),
  );
