/** The cameras of an arm: each has a small canvas, and the chosen one fills the screen. */
import { byId, make, set } from "../kit/dom.ts";
import { CameraView } from "../media/camera_view.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { Still } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";

export class Cameras {
  private chosen = 0;
  private narrow = matchMedia("(max-width: 45.99rem), (max-height: 30rem)");
  private picked = byId<HTMLCanvasElement>("picture");
  private overlay = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  private screen = new CameraView(byId("screen"), this.picked, this.overlay, (u, v) => {
    const { width, height } = this.picked;
    if (this.calibrated.length) this.onPick(this.shownName, [u / width, v / height], width / height);
  });
  private small: CameraView[];
  private buttons: HTMLElement[];
  private canvas = make("canvas", { class: "model-picture", "aria-hidden": "true" });
  private back = new CameraView(byId("model"), this.canvas, null, () => undefined); // behind the scene
  private behindIs = -1; // the camera whose pictures are there
  /** Called with the camera whose picture is clicked on, where (shares of width and height), and width by height. */
  onPick: (name: string, at: readonly [number, number], aspect: number) => void = () => undefined;
  /** Called when a picture of another camera or size is shown. */
  onShown: () => void = () => undefined;
  private places: readonly string[] = [];

  constructor(private page: RobotPage) {
    set(this.overlay, { "aria-hidden": "true" });
    this.picked.after(this.overlay);
    const buttons = (this.buttons = [...byId("views").querySelectorAll<HTMLElement>("[data-view]")]);
    this.small = buttons.map((button) => new CameraView(button, button.querySelector("canvas")!, null, () => undefined));
    for (const [i, button] of buttons.entries())
      button.addEventListener("click", () => {
        this.chosen = i;
        for (const [k, other] of buttons.entries()) other.setAttribute("aria-pressed", String(k === i));
        this.screen.forget();
        this.watch();
        this.showCross();
        this.onShown();
      });
    this.narrow.addEventListener("change", () => this.watch());
  }

  /** Ask for the pictures of all cameras; on a phone, which shows one at a time, only for that one. */
  watch(): void {
    const few = [this.chosen, this.behindIs].filter((one, i, all) => one >= 0 && all.indexOf(one) === i);
    this.page.watch(this.narrow.matches ? few : this.small.map((_, i) => i));
  }

  picture(packet: PicturePacket): void {
    void this.small[packet.camera]?.show(packet);
    if (packet.camera === this.behindIs) void this.back.show(packet);
    if (packet.camera === this.chosen)
      void this.screen.show(packet).then(() => {
        this.fit();
        this.page.draw();
      });
  }

  /** The cameras in whose pictures a place can be chosen, by name. */
  get calibrated(): readonly string[] {
    return this.places;
  }

  set calibrated(names: readonly string[]) {
    this.places = names;
    this.showCross();
  }

  private showCross(): void {
    const screen = byId("screen");
    screen.classList.toggle("aimed", this.places.includes(this.shownName));
  }

  /** The name of the camera on the screen. */
  get shownName(): string {
    return this.buttons[this.chosen]?.dataset["name"] ?? "";
  }

  /** Width of the picture on the screen by its height. */
  get aspect(): number {
    return this.picked.width / this.picked.height;
  }

  /** Show a place in the picture on the screen (shares of width and height); null: none. */
  mark(at: readonly [number, number] | null): void {
    this.fit();
    this.screen.aim(at && [at[0] * this.picked.width, at[1] * this.picked.height], null);
  }

  private fit(): void {
    const { width, height } = this.picked,
      box = `0 0 ${width} ${height}`;
    if (this.overlay.getAttribute("viewBox") === box) return;
    set(this.overlay, { viewBox: box });
    this.onShown();
  }

  still(still: Still): void {
    if (this.chosen === 0) this.screen.still(still, () => this.page.draw());
  }

  /** Draw the pictures of a camera behind the scene, the one that is here at once; null: none. */
  behind(name: string | null): void {
    const { canvas } = this,
      is = this.buttons.findIndex((button) => button.dataset["name"] === name);
    if (is === this.behindIs) return;
    this.behindIs = is;
    if (is < 0) canvas.remove();
    else byId("model").prepend(canvas);
    this.back.forget();
    const here = this.small[is],
      picture = this.buttons[is]?.querySelector("canvas");
    if (here?.atMs && picture) this.back.draw(picture, here.atMs, here.stillId);
    else canvas.getContext("2d")?.clearRect(0, 0, canvas.width, canvas.height);
    this.watch();
  }

  get behindAtMs(): number {
    return this.back.atMs;
  }

  shown(camera: number): CameraView | undefined {
    return this.small[camera];
  }

  /** When the picture on the screen was taken (server ms). */
  get atMs(): number {
    return this.screen.atMs;
  }
}
