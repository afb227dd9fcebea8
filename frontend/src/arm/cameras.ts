/** The cameras of an arm: each has a small canvas, and the chosen one fills the screen. */
import { byId } from "../kit/dom.ts";
import { CameraView } from "../media/camera_view.ts";
import type { RobotPage } from "../page/robot_page.ts";
import type { Still } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";

export class Cameras {
  private chosen = 0;
  private narrow = matchMedia("(max-width: 45.99rem)");
  private screen = new CameraView(byId("screen"), byId<HTMLCanvasElement>("picture"), null, () => undefined);
  private small: CameraView[];

  constructor(private page: RobotPage) {
    const buttons = [...byId("views").querySelectorAll<HTMLElement>("[data-view]")];
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
    this.page.watch(this.narrow.matches ? [this.chosen] : this.small.map((_, i) => i));
  }

  picture(packet: PicturePacket): void {
    void this.small[packet.camera]?.show(packet);
    if (packet.camera === this.chosen) void this.screen.show(packet).then(() => this.page.draw());
  }

  still(still: Still): void {
    if (this.chosen === 0) this.screen.still(still, () => this.page.draw());
  }

  shown(camera: number): CameraView | undefined {
    return this.small[camera];
  }

  /** When the picture on the screen was taken (server ms). */
  get atMs(): number {
    return this.screen.atMs;
  }
}
