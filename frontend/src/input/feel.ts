/** Depth is felt: where the ghost meets a surface or snaps, a gamepad or a phone shakes, else a soft tone sounds. */
import { storage } from "../kit/storage.ts";

/** What was met. */
export type Touch = "surface" | "snap";
export type Way = "rumble" | "vibration" | "sound" | "";

/** What this browser and its person allow. */
export interface Senses {
  shakes: boolean; // the person wants to feel it
  sounds: boolean; // ... and hear it
  isCalm: boolean; // the person has asked for less motion
  hasPad: boolean; // a gamepad that can shake moves the ghost
  hasPhone: boolean; // a finger moves it on a device that can vibrate
}

const AGAIN_MS = 120; // a hand that trembles at a surface is no drum
const EFFECTS = {
  surface: { duration: 60, strongMagnitude: 0.5, weakMagnitude: 0.5, vibrate_ms: 25, hertz: 196 },
  snap: { duration: 40, strongMagnitude: 0, weakMagnitude: 0.7, vibrate_ms: 12, hertz: 523 },
} as const;
const LOUD = 0.06,
  TONE_S = 0.12;

/** Return by which way it is told; colour tells it too, always. */
export function wayOf({ shakes, sounds, isCalm, hasPad, hasPhone }: Senses): Way {
  if (shakes && !isCalm && hasPad) return "rumble";
  if (shakes && !isCalm && hasPhone) return "vibration";
  return sounds ? "sound" : "";
}

export class Feel {
  private audio: AudioContext | null = null;
  private toldAt = -Infinity;
  private calm = matchMedia("(prefers-reduced-motion: reduce)");
  private readonly shakes: HTMLInputElement;
  private readonly sounds: HTMLInputElement;

  /** The switches of the person: shaking is on at first, sound is off until the switch was pressed on this page. */
  constructor(shakes: HTMLInputElement, sounds: HTMLInputElement) {
    [this.shakes, this.sounds] = [shakes, sounds];
    shakes.checked = storage.get("feel") !== "off";
    shakes.addEventListener("change", () => storage.set("feel", shakes.checked ? "on" : "off"));
    sounds.checked = false;
    sounds.addEventListener("change", () => this.open());
  }

  /** Open the audio during the press, because browsers play nothing before one. */
  private open(): void {
    try {
      if (this.sounds.checked) this.audio ??= new AudioContext();
      void (this.sounds.checked ? this.audio?.resume() : this.audio?.suspend())?.catch(() => undefined);
    } catch {
      this.sounds.checked = false; // this browser plays nothing
    }
  }

  /** Tell what was met. `by`: what moves the ghost. */
  tell(touch: Touch, by: "gamepad" | "finger" | "other"): void {
    const now = performance.now();
    if (now - this.toldAt < AGAIN_MS) return;
    this.toldAt = now;
    const pads = by === "gamepad" ? shaking() : [];
    const way = wayOf({
      shakes: this.shakes.checked,
      sounds: this.sounds.checked,
      isCalm: this.calm.matches,
      hasPad: pads.length > 0,
      hasPhone: by === "finger" && "vibrate" in navigator && navigator.userActivation.hasBeenActive,
    });
    const { vibrate_ms, hertz, ...effect } = EFFECTS[touch];
    if (way === "rumble") for (const pad of pads) pad.playEffect("dual-rumble", effect).catch(() => undefined);
    else if (way === "vibration") navigator.vibrate(vibrate_ms);
    else if (way === "sound" && this.audio?.state === "running") play(this.audio, hertz);
  }
}

function shaking(): GamepadHapticActuator[] {
  if (!("getGamepads" in navigator)) return [];
  return navigator.getGamepads().flatMap((pad) => (pad as Partial<Gamepad> | null)?.vibrationActuator ?? []);
}

function play(audio: AudioContext, hertz: number): void {
  const tone = audio.createOscillator(),
    volume = audio.createGain(),
    at = audio.currentTime;
  tone.frequency.value = hertz;
  volume.gain.setValueAtTime(LOUD, at);
  volume.gain.exponentialRampToValueAtTime(0.001, at + TONE_S);
  tone.connect(volume).connect(audio.destination);
  tone.start(at);
  tone.stop(at + TONE_S);
}
