/** Pictures, video, sound and byte streams of a robot's page: what it asks for, and what becomes of what comes. */
import { byId, say } from "../kit/dom.ts";
import { decimals, gettext } from "../kit/text.ts";
import { pictureAge, skipsForReducedMotion } from "../media/pictures.ts";
import { Sound } from "../media/sound.ts";
import { Subscription } from "../media/subscription.ts";
import { VideoPlayer } from "../media/video.ts";
import { ByteStreams } from "../socket/byte_streams.ts";
import { type Connection, isReplay } from "../socket/connection.ts";
import type { Snapshot } from "../socket/messages.ts";
import type { PicturePacket, StreamPacket, VideoPacket } from "../socket/packets.ts";
import { splitPicture } from "../socket/poses.ts";
import type { Handlers } from "../socket/robot_socket.ts";
import type { Console } from "./console.ts";
import type { Facts } from "./controls.ts";
import { facts } from "./facts.ts";

const RATE_MS = 3000; // with an older picture the page does not say how many come

/** The parts of the page that `Media` needs. */
interface MediaUse {
  connection(): Connection;
  console(): Console | null;
  snapshot(): Snapshot | null;
}

export class Media {
  readonly subscription: Subscription;
  private calm = matchMedia("(prefers-reduced-motion: reduce)");
  private player: VideoPlayer;
  private sound: Sound | null = null;
  private streams = new ByteStreams(facts.streams.map(({ name }) => name));

  constructor(private use: MediaUse) {
    const saving = (navigator as { connection?: { saveData?: boolean } }).connection?.saveData ?? false;
    this.subscription = new Subscription(() => use.connection(), facts.video, saving, isReplay());
    this.player = new VideoPlayer(
      facts.video,
      (packet) => this.show(packet),
      (on) => this.subscription.video(on),
    );
    const pace = byId<HTMLSelectElement>("pace");
    pace.value = this.subscription.choice;
    pace.addEventListener("change", () => {
      this.subscription.choose(pace.value);
      this.still();
    });
    if (document.getElementById("sound"))
      this.sound = new Sound(byId("sound"), byId("sound-said"), byId<HTMLMeterElement>("loudness"), (on) => this.subscription.listen(on));
    document.addEventListener("visibilitychange", () => document.hidden || this.subscription.again());
  }

  /** What the connection calls with each packet. */
  readonly handlers: Pick<Handlers, "picture" | "stream" | "video" | "sound" | "took"> = {
    picture: (packet) => this.picture(packet),
    stream: (packet) => this.take(packet),
    video: (packet) => this.video(packet),
    sound: (packet) => this.sound?.take(packet),
    took: (bytes) => this.subscription.took(bytes),
  };

  /** A console is installed: have video if it and this browser can show it. */
  begin(console: Console): void {
    if (console.video) void VideoPlayer.possible(facts.video).then((can) => can && this.subscription.video(true));
  }

  /** Show the newest still, unless the line is for values alone: one picture would keep them back for minutes. */
  still(): void {
    const still = this.use.snapshot()?.still;
    if (still && this.subscription.pace !== "states") this.use.console()?.still(still);
  }

  /** The newest key packet of a byte stream and the deltas after it; empty if none has arrived. */
  stream(name: string): StreamPacket[] {
    return this.streams.of(name);
  }

  private take(packet: StreamPacket): void {
    const name = this.streams.take(packet);
    if (name !== undefined) this.use.console()?.stream?.(name, packet);
  }

  private video(packet: VideoPacket): void {
    this.subscription.arrived(packet, packet.coded.length);
    this.player.take(packet);
  }

  private picture(packet: PicturePacket): void {
    this.subscription.arrived(packet, packet.jpeg.size);
    this.show(splitPicture(packet, facts.names.length, facts.pose.length));
  }

  /** With reduced motion, people who only watch get stills and one live picture every ten seconds. */
  private show(packet: PicturePacket): void {
    const console = this.use.console(),
      snapshot = this.use.snapshot();
    const shown = console?.shown(packet.camera),
      still = snapshot?.still;
    const placed = packet.pose?.length || !still || still.id !== packet.still ? packet : { ...packet, pose: still.pose };
    if (this.calm.matches && !snapshot?.me.can.drive && !isReplay() && shown && skipsForReducedMotion(packet, shown)) return;
    console?.picture(placed);
  }

  /** Say how old the picture is, what comes over the line, and how well. */
  draw(f: Facts): void {
    const at = this.use.console()?.pictureAt() ?? 0,
      age = at ? f.now - at : Infinity;
    const rate = age < RATE_MS ? this.subscription.rate() : 0;
    const often = rate < 9.5 ? decimals(rate, 1) : String(Math.round(rate));
    const [words, mark] = pictureAge(age, rate ? often : "");
    const badge = byId("age");
    say(badge, at ? words : facts.cameras ? gettext("No picture yet") : "");
    badge.dataset["age"] = mark;
    say(byId("pace-said"), this.subscription.judgeLine(facts.cameras > 0 && f.snapshot?.robot.state !== "offline"));
    say(byId("line-said"), this.subscription.lineSentence());
    this.sound?.draw(this.subscription.soundless);
    say(byId("latency"), f.latency === null ? "" : `${Math.round(f.latency)} ms`);
  }
}
