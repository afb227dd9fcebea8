/** The camera's picture, with a cross where the next one will be centred, and the place of the tool. */
import { set, shape } from "../kit/dom.ts";
import type { Still } from "../socket/messages.ts";
import type { PicturePacket } from "../socket/packets.ts";
import { PictureOrder } from "./pictures.ts";

type Drawable = ImageBitmap | HTMLImageElement | HTMLCanvasElement | VideoFrame;

/** Return width and height of an image (px). */
function sizeOf(image: Drawable): [number, number] {
  if ("naturalWidth" in image) return [image.naturalWidth, image.naturalHeight];
  return "displayWidth" in image ? [image.displayWidth, image.displayHeight] : [image.width, image.height];
}

export class CameraView {
  /** When the picture on screen was taken, server ms. */
  atMs = 0;
  /** The stored picture to which it belongs; 0 while the robot moves. */
  stillId = 0;
  /** The robot's pose then, by the coordinates of its spec; empty if not known. */
  pose: readonly number[] = [];
  private context: CanvasRenderingContext2D;
  private order = new PictureOrder();
  private views = 0;
  private cross: SVGGElement | null = null;
  private tool: SVGCircleElement | null = null;
  private path: SVGLineElement | null = null;
  private at: [number, number] | null = null;

  constructor(
    screen: HTMLElement,
    private canvas: HTMLCanvasElement,
    overlay: SVGSVGElement | null,
    onPick: (u: number, v: number) => void,
  ) {
    this.context = canvas.getContext("2d")!;
    if (!overlay) return;
    this.tool = shape(overlay, "circle", { class: "tool-place", r: 4.5, cx: -20, cy: -20 });
    this.path = shape(overlay, "line", { class: "path", x1: -9, y1: -9, x2: -9, y2: -9 });
    const cross = (this.cross = shape(overlay, "g", { class: "cross", transform: "translate(-50 -50)" }));
    shape(cross, "circle", { r: 7, cx: 0, cy: 0 });
    for (const turn of [0, 90, 180, 270]) shape(cross, "line", { x1: 4, x2: 12, y1: 0, y2: 0, transform: `rotate(${turn})` });
    screen.addEventListener("click", (event) => {
      const box = canvas.getBoundingClientRect();
      onPick(((event.clientX - box.left) / box.width) * canvas.width, ((event.clientY - box.top) / box.height) * canvas.height);
    });
    screen.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return; // the browser's own, as Alt and an arrow
      const step = event.shiftKey ? 20 : 4;
      const keys: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      const way = keys[event.key];
      if (!way) return;
      event.preventDefault();
      const { width, height } = canvas;
      const [u, v] = this.at ?? [width / 2, height / 2];
      onPick(Math.min(width - 1, Math.max(0, u + step * way[0])), Math.min(height - 1, Math.max(0, v + step * way[1])));
    });
  }

  /** Show a picture; one that is older than the picture shown is dropped. */
  async show(packet: PicturePacket): Promise<void> {
    if (!this.order.take(packet)) return;
    if (packet.image) {
      this.draw(packet.image, packet.atMs, packet.still, packet.pose);
      return;
    }
    const { views } = this;
    const bitmap = await createImageBitmap(packet.jpeg);
    if (views === this.views && this.order.holds(packet)) this.draw(bitmap, packet.atMs, packet.still, packet.pose);
    bitmap.close();
  }

  /** Load a stored picture and show it, unless a newer one is shown by then; `then` is called when it has loaded. */
  still(still: Still, then: () => void): void {
    if (this.atMs >= still.at_ms) return;
    const image = new Image();
    const { views } = this;
    image.onload = () => {
      if (views === this.views && this.atMs < still.at_ms) this.draw(image, still.at_ms, still.id, still.pose);
      then();
    };
    image.src = still.url;
  }

  /** Forget all pictures: those of another camera follow. */
  forget(): void {
    this.order.forget();
    this.views += 1;
    this.atMs = this.stillId = 0;
    this.pose = [];
  }

  draw(image: Drawable, atMs: number, still: number, pose: readonly number[] = []): void {
    const [width, height] = sizeOf(image);
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
    this.context.drawImage(image, 0, 0);
    this.atMs = atMs;
    this.stillId = still;
    this.pose = pose;
    this.canvas.dataset["still"] = String(still);
    this.canvas.dataset["at"] = String(atMs);
  }

  /** Show where the next picture will be centred, and the line from the tool to there; null hides them (px). */
  aim(at: [number, number] | null, from: [number, number] | null): void {
    this.at = at;
    if (!this.cross || !this.tool || !this.path) return;
    const [u, v] = at ?? [-50, -50]; // outside of the picture
    const [nu, nv] = from ?? [-20, -20];
    set(this.cross, { transform: `translate(${u} ${v})` });
    set(this.tool, { cx: nu, cy: nv });
    set(this.path, at && from ? { x1: nu, y1: nv, x2: u, y2: v } : { x1: -9, y1: -9, x2: -9, y2: -9 });
  }
}
