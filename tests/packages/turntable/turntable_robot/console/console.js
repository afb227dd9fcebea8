/** The turntable's own console: a dial that shows the table, a slider that says where it shall turn. */
import { allow, RobotPage, say, shape } from "/static/farhand/v1/console.js";

const page = new RobotPage();
const dial = document.getElementById("turntable");
const goal = document.getElementById("turntable-goal");
const said = document.getElementById("turntable-said");
const turn = document.querySelector("[data-command=turn]");

const picture = document.createElementNS("http://www.w3.org/2000/svg", "svg");
picture.setAttribute("viewBox", "-110 -110 220 220");
dial.append(picture);
shape(picture, "circle", { r: 100, class: "plate" });
const wanted = shape(picture, "line", { x1: 0, y1: 0, x2: 0, y2: -90, class: "goal" });
const pointer = shape(picture, "line", { x1: 0, y1: 0, x2: 0, y2: -90, class: "pointer" });
const rad = (degrees) => (degrees * Math.PI) / 180;
const deg = (radians) => (radians * 180) / Math.PI;

function aim() {
  say(said, `${goal.value}°`);
  wanted.setAttribute("transform", `rotate(${-goal.value})`);
}

goal.addEventListener("input", aim);
page.on("turn", () => page.command("turn", { angle: rad(Number(goal.value)) }));
const pace = document.getElementById("turntable-pace");
const setPace = document.querySelector("[data-command=pace]");
pace.addEventListener("input", () => say(document.getElementById("turntable-pace-said"), `${Number(pace.value).toFixed(1)} rad/s`));
page.on("pace", () => page.command("pace", { pace: Number(pace.value) }));
const cells = new Uint8Array(63); // of the circle, a tenth of a radian each: how often the table pointed there
const marks = [...cells].map((_, cell) => shape(picture, "line", { x1: 0, y1: -92, x2: 0, y2: -98, class: "mark", transform: `rotate(${-deg((cell + 0.5) / 10 - 3.15)})` }));
page.begin({
  stream(name, { key, data }) {
    if (key) cells.set(data);
    else for (let at = 0; at < data.length; at += 2) cells[data[at]] = data[at + 1];
    marks.forEach((mark, cell) => mark.setAttribute("opacity", Math.min(1, cells[cell] / 20)));
    dial.dataset[name] = cells.filter((n) => n > 0).length;
  },
  state() {
    const angle = deg(page.value("table") ?? 0);
    pointer.setAttribute("transform", `rotate(${-angle})`);
    dial.dataset.angle = angle.toFixed(1);
    const warmth = page.value("warmth");
    say(document.getElementById("turntable-warmth"), warmth === undefined ? "not known" : `${warmth.toFixed(0)} °C`);
    dial.setAttribute("aria-label", `The table from above, turned to ${angle.toFixed(0)} degrees`);
  },
  draw() {
    goal.disabled = !page.operating;
    allow(turn, page.whyNot("turn"));
    allow(setPace, page.whyNot("pace")); // beside a motion too: it sets something
    document.querySelector(".turntable-pace").hidden = !page.operating;
  },
});
aim();
