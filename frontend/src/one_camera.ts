/** What the consoles of robots with a single camera share. */
import type { CameraView } from "./camera.ts";
import type { PicturePacket } from "./protocol.ts";

export abstract class OneCamera {
  protected abstract camera: CameraView;

  constructor(private shownAnew: () => void) {}

  picture(packet: PicturePacket): void {
    if (packet.camera === 0) void this.camera.show(packet).then(this.shownAnew);
  }

  shown(): CameraView {
    return this.camera;
  }

  pictureAt(): number {
    return this.camera.atMs;
  }
}
