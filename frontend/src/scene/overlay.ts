/** The scene as a calibrated camera sees it, half transparent over that camera's picture. */
import { byId, say } from "../kit/dom.ts";
import { gettext, translate } from "../kit/text.ts";
import type { CameraPlace, SceneView } from "./view.ts";

/** The pictures of the robot's cameras. */
export interface Pictures {
  /** Draw the pictures of a camera behind the scene, and ask for them; null: none. */
  behind(name: string | null): void;
  /** When the picture behind the scene was taken (server ms); 0 if none has come. */
  readonly behindAtMs: number;
}

export class Overlay {
  private camera: CameraPlace | null = null;
  private wanted = byId<HTMLInputElement>("camera-picture");
  private said = byId("camera-picture-said");

  /** `now`: the server's time (ms). */
  constructor(
    private view: SceneView,
    private pictures: Pictures,
    private now: () => number,
  ) {
    byId("camera-picture-row").hidden = false;
    this.wanted.addEventListener("change", () => this.show());
    view.onTurned = () => this.leave();
  }

  /** Look as a camera does, over its picture if that is wanted. */
  look(camera: CameraPlace): void {
    this.view.asCamera(camera);
    this.camera = camera;
    this.show();
  }

  /** Look from elsewhere: no picture belongs to the view any more. */
  leave(): void {
    this.camera = null;
    this.show();
  }

  private show(): void {
    const shown = this.wanted.checked ? this.camera : null;
    this.pictures.behind(shown?.name ?? null);
    this.view.overPicture(shown !== null);
    this.draw();
  }

  /** Say what is seen, and how old the picture is. */
  draw(): void {
    say(this.said, this.words());
  }

  private words(): string {
    if (!this.wanted.checked) return "";
    if (!this.camera) return gettext("Choose a camera.");
    const { behindAtMs } = this.pictures,
      age = Math.max(0, Math.round((this.now() - behindAtMs) / 1000));
    const camera = translate(this.camera.name);
    if (!behindAtMs) return gettext("No picture of camera {camera} has come yet.", { camera });
    const right = gettext("Where both differ, the picture is right.");
    if (age < 10) return `${gettext("The model lies over the picture of camera {camera}.", { camera })} ${right}`;
    const old = age < 120 ? `${age - (age % 10)} s` : `${Math.floor(age / 60)} min`;
    return `${gettext("The model lies over the picture of camera {camera}, {age} old.", { camera, age: old })} ${right}`;
  }
}
