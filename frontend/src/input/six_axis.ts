/** A 6D mouse over WebHID: asked for by a press of its button only, and gone as soon as it is unplugged. */
import { capAfter, type Cap, FILTER, REST } from "./hid.ts";
import { type Reading, type Source, STILL } from "./source.ts";
import { pushed } from "./speeds.ts";
import { gettext } from "../kit/text.ts";

/** What is used of WebHID, which not every browser has. */
interface HidReport extends Event {
  reportId: number;
  data: DataView;
  device: HidDevice;
}
export interface HidDevice {
  productName: string;
  opened: boolean;
  open(): Promise<void>;
  addEventListener(name: "inputreport", act: (event: HidReport) => void): void;
}
export interface Hid {
  requestDevice(options: { filters: object[] }): Promise<HidDevice[]>;
  addEventListener(name: "disconnect", act: (event: { device: HidDevice }) => void): void;
}

const HOLD = 1,
  GRIP = 2; // the bits of its first two buttons
const SILENT_S = 0.25; // a cap that is pushed reports all the time; after so long without a report it counts as at rest

export class SixAxis implements Source {
  readonly name = "6D mouse";
  readonly isRate = true;
  private device: HidDevice | null = null;
  private cap: Cap = REST;
  private silent_s = 0;
  private rested = false; // what was held since before it counted does not count
  private closes = true; // what the next press of its second button does
  private held = 0; // its buttons at the reading before
  private readonly hid: Hid | null;
  private readonly here: () => boolean;
  private readonly gone: () => void;

  /** `here`: whether it may move the ghost now. `gone`: called when it was unplugged. */
  constructor(hid: Hid | null, here: () => boolean, gone: () => void) {
    [this.hid, this.here, this.gone] = [hid, here, gone];
    hid?.addEventListener("disconnect", ({ device }) => device === this.device && this.lose());
  }

  /** Ask the person for a device. Returns what to say. */
  async connect(): Promise<string> {
    if (!this.hid) return gettext("This browser cannot use a 6D mouse (it has no WebHID). A gamepad and the keys do the same.");
    try {
      const [device] = await this.hid.requestDevice({ filters: [FILTER] });
      if (!device) return gettext("No 6D mouse was chosen.");
      if (!device.opened) await device.open();
      if (device !== this.device) device.addEventListener("inputreport", (event) => this.hear(event));
      this.device = device;
      this.forget();
      return gettext("{device} moves the ghost. Its first button holds, its second closes and opens the gripper.", {
        device: device.productName || gettext("The 6D mouse"),
      });
    } catch {
      return gettext("The 6D mouse could not be opened; another program may use it.");
    }
  }

  private hear({ reportId, data, device }: HidReport): void {
    if (device !== this.device) return;
    this.cap = capAfter(this.cap, reportId, data);
    this.silent_s = 0;
  }

  private lose(): void {
    this.device = null;
    this.cap = REST;
    this.gone();
  }

  read(elapsed_s: number): Reading | null {
    if (!this.device || !this.here()) {
      this.forget();
      return null;
    }
    this.silent_s += elapsed_s;
    if (this.silent_s > SILENT_S) this.cap = { ...this.cap, push: STILL };
    const { push, buttons } = this.cap,
      isPushed = push.some((v) => v !== 0);
    if (!buttons && !isPushed) this.rested = true;
    const before = this.held;
    this.held = buttons;
    if (!this.rested || (!buttons && !isPushed)) return null;
    const isGrip = (buttons & GRIP) !== 0 && (before & GRIP) === 0,
      grip = isGrip ? (this.closes ? "close" : "open") : "";
    if (isGrip) this.closes = !this.closes;
    return { by: pushed(push, elapsed_s), clutch: (buttons & HOLD) !== 0, grip };
  }

  forget(): void {
    this.rested = false;
    this.held = this.cap.buttons;
  }
}
