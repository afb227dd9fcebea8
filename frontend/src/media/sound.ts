/** The robot's sound: a button, the browser's decoder (WebCodecs), and what is heard now. Off until it is pressed. */
import { say } from "../kit/dom.ts";
import { allow, refusal } from "../kit/refusal.ts";
import { gettext, translate } from "../kit/text.ts";
import type { SoundPacket } from "../socket/packets.ts";
import { PlayoutBuffer } from "./playout.ts";

const RATE = 48_000;
const CONFIG: AudioDecoderConfig = { codec: "opus", sampleRate: RATE, numberOfChannels: 1 };
const HIDDEN_MS = 5000; // a page that nobody sees for so long is silent
const SILENT_MS = 4000; // after so long without a packet the page says that no sound comes
const WAITING = 10; // with more pieces than this in it the decoder is reset
const QUIET_DB = -60; // the lower end of the scale
const CANNOT = gettext("This browser cannot play the robot's sound.");
const BEGINS_MS = 1000; // a browser that plays sound begins within this time
const PAUSED = gettext("Sound paused. Press to hear again.");

/** Everything that is open while somebody listens. */
class Playing {
  readonly context = new AudioContext({ sampleRate: RATE, latencyHint: "interactive" });
  private analyser = this.context.createAnalyser();
  private decoder: AudioDecoder;
  private line = new PlayoutBuffer();
  private waiting: SoundPacket[] = []; // in the decoder, which returns one piece for each, in their order
  private sources = new Map<AudioBufferSourceNode, number>(); // when each begins, s
  private run = -1;
  private decodedMs = 0;
  private ranAt = performance.now();

  /** `changed` is called when the browser pauses the sound, for a telephone call say, or plays it again. */
  constructor(failed: () => void, changed: () => void) {
    this.analyser.fftSize = 2048;
    this.analyser.connect(this.context.destination);
    this.decoder = new AudioDecoder({ output: (data) => this.decoded(data), error: failed });
    this.decoder.configure(CONFIG);
    this.context.addEventListener("statechange", changed);
    this.resume();
  }

  /** Ask the browser to play; some browsers obey only during a press. */
  resume(): void {
    if (this.context.state !== "running") this.context.resume().catch(() => undefined);
  }

  /** Whether the browser plays nothing. */
  get paused(): boolean {
    const now = performance.now();
    if (this.context.state === "running") this.ranAt = now;
    return now - this.ranAt > BEGINS_MS;
  }

  take(packet: SoundPacket): void {
    if (packet.run !== this.run || this.waiting.length > WAITING) {
      this.run = packet.run;
      this.decoder.reset();
      this.decoder.configure(CONFIG);
      this.waiting = [];
    }
    this.waiting.push(packet);
    const timestamp = this.decodedMs * 1000; // without gaps, as decoders count on by themselves
    this.decodedMs += packet.ms;
    this.decoder.decode(new EncodedAudioChunk({ type: "key", timestamp, data: packet.opus }));
  }

  private decoded(data: AudioData): void {
    try {
      const packet = this.waiting.shift();
      if (packet) this.play(packet, data);
    } finally {
      data.close();
    }
  }

  private play(packet: SoundPacket, data: AudioData): void {
    const { context } = this,
      seconds = packet.ms / 1000;
    const due = this.line.take({ run: packet.run, number: packet.number, seconds }, context.currentTime);
    if (due.drop) this.drop();
    if (due.at === null) return;
    const buffer = context.createBuffer(1, data.numberOfFrames, data.sampleRate);
    data.copyTo(buffer.getChannelData(0), { planeIndex: 0, format: "f32-planar" });
    const source = context.createBufferSource();
    source.buffer = buffer;
    source.connect(this.analyser);
    source.onended = () => this.sources.delete(source);
    source.start(due.at);
    this.sources.set(source, due.at);
  }

  /** Drop the pieces that have not begun. */
  private drop(): void {
    for (const [source, at] of this.sources)
      if (at > this.context.currentTime) {
        source.stop();
        source.disconnect();
        this.sources.delete(source);
      }
  }

  /** How loud it is now, dB below full scale; -Infinity for silence. */
  get loudness(): number {
    const samples = new Float32Array(this.analyser.fftSize);
    this.analyser.getFloatTimeDomainData(samples);
    return 10 * Math.log10(samples.reduce((sum, x) => sum + x * x, 0) / samples.length);
  }

  close(): void {
    if (this.decoder.state !== "closed") this.decoder.close();
    void this.context.close();
  }
}

export class Sound {
  private playing: Playing | null = null;
  private on = false;
  private why = ""; // why no sound is sent although the person listens
  private said = ""; // the robot's own sentence about its sound
  private heardAt = 0; // the last packet, performance.now
  private hiding = 0;
  private away = false; // nobody has seen the page for a while
  private paused = false; // the browser plays nothing, and the page says so

  private readonly button: HTMLElement;
  private readonly words: HTMLElement;
  private readonly meter: HTMLMeterElement;
  private readonly ask: (on: boolean) => void;

  /** `ask` asks the server for sound, or to stop it: true while the person listens and nothing prevents it. */
  constructor(button: HTMLElement, words: HTMLElement, meter: HTMLMeterElement, ask: (on: boolean) => void) {
    [this.button, this.words, this.meter, this.ask] = [button, words, meter, ask];
    button.addEventListener("click", () => this.press());
    document.addEventListener("visibilitychange", () => this.hide());
    for (const name of ["pageshow", "focus", "pointerdown", "pointerup", "keydown"])
      addEventListener(name, ({ target }) => this.again(target), { capture: true, passive: true });
    void possible().then((can) => can || this.giveUp());
  }

  private press(): void {
    const why = refusal(this.button);
    if (why) say(this.words, why);
    else if (this.paused) this.anew();
    else this.set(!this.on);
  }

  /** Begin anew during a press, because some browsers never resume a context that they have paused. */
  private anew(): void {
    this.playing?.close();
    this.playing = null;
    this.wake();
  }

  private wake(): void {
    this.away = false;
    this.heardAt = performance.now();
    this.open(!this.why);
    this.playing?.resume();
    this.draw(this.why);
  }

  /** Resume at any press on the page except on the button, which does it itself. */
  private again(target: EventTarget | null): void {
    if (!document.hidden && !(target instanceof Node && this.button.contains(target))) this.playing?.resume();
  }

  /** Stop the sound of a page that nobody has seen for a while, and resume it when somebody sees the page again. */
  private hide(): void {
    clearTimeout(this.hiding);
    if (!this.on) return;
    if (!document.hidden) return this.wake();
    this.hiding = window.setTimeout(() => {
      this.away = true;
      this.open(false);
    }, HIDDEN_MS);
  }

  private set(on: boolean): void {
    this.on = on;
    this.away = false;
    this.said = "";
    this.heardAt = performance.now();
    this.open(on && !this.why);
    this.draw(this.why);
  }

  private open(on: boolean): void {
    try {
      if (on) this.playing ??= new Playing(this.giveUp, () => this.changed());
    } catch {
      return this.giveUp();
    }
    if (!on) {
      this.playing?.close();
      this.playing = null;
    }
    this.ask(on);
  }

  private changed(): void {
    if (!document.hidden) this.playing?.resume();
    this.draw(this.why);
  }

  /** Say that this browser plays nothing, and listen no more. */
  private readonly giveUp = (): void => {
    if (this.on) this.set(false);
    allow(this.button, CANNOT);
    say(this.words, CANNOT);
  };

  take(packet: SoundPacket): void {
    if (!this.playing) return;
    this.said = translate(packet.said);
    this.heardAt = performance.now();
    if (packet.said) return;
    try {
      this.playing.take(packet);
    } catch {
      this.giveUp();
    }
  }

  /** Show what is heard. `why`: why no sound is sent to this page now, empty if it may be. */
  draw(why: string): void {
    if (why !== this.why) {
      this.why = why;
      if (this.on && !this.away) this.open(!why);
      this.heardAt = performance.now();
    }
    this.paused = this.on && this.playing?.paused === true;
    this.button.setAttribute("aria-pressed", String(this.on && !this.paused));
    const level = this.playing ? Math.max(0, 1 - this.playing.loudness / QUIET_DB) : 0;
    this.meter.hidden = !this.playing;
    this.meter.value = level;
    if (!refusal(this.button)) say(this.words, this.on ? why || (this.paused ? PAUSED : this.said || this.silence()) : "");
  }

  private silence(): string {
    return performance.now() - this.heardAt > SILENT_MS ? gettext("No sound comes now.") : "";
  }
}

async function possible(): Promise<boolean> {
  if (!("AudioDecoder" in globalThis) || !("AudioContext" in globalThis)) return false;
  try {
    return (await AudioDecoder.isConfigSupported(CONFIG)).supported === true;
  } catch {
    return false;
  }
}
