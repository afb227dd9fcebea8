/** The cameras of an arm: each has a small canvas, and the chosen one fills the screen. */
import { byId, make } from "../kit/dom.ts";
import { CameraView } from "../media/camera_view.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { Still } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";

export class Cameras {
  private chosen = 0;
  private narrow = matchMedia("(max-width: 45.99rem)");
  private screen = new CameraView(byId("screen"), byId<HTMLCanvasElement>("picture"), null, () => undefined);
  private small: CameraView[];
  private buttons: HTMLElement[];
  private canvas = make("canvas", { class: "model-picture", "aria-hidden": "true" });
  private back = new CameraView(byId("model"), this.canvas, null, () => undefined); // behind the scene
  private behindIs = -1; // the camera whose pictures are there

  constructor(private page: RobotPage) {
    const buttons = (this.buttons = [...byId("views").querySelectorAll<HTMLElement>("[data-view]")]);
    this.small = buttons.map((button) => new CameraView(button, button.querySelector("canvas")!, null, () => undefined));
    for (const [i, button] of buttons.entries())
      button.addEventListener("click", () => {
        this.chosen = i;
        for (const [k, other] of buttons.entries()) other.setAttribute("aria-pressed", String(k === i));
        this.screen.forget();
        this.watch();
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
    if (packet.camera === this.chosen) void this.screen.show(packet).then(() => this.page.draw());
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
