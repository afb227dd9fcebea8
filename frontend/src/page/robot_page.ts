/** The part of every robot's page: socket, turn panel, command list, stop and release, log. */
import { ScreenWakeLock } from "../kit/wake_lock.ts";
import { bannerWords, unconfirmedStop } from "./banner.ts";
import type { Console } from "./console.ts";
import { blocked, type Facts } from "./controls.ts";
import { skipsForReducedMotion } from "../media/reduced_motion.ts";
import { facts, configKinds } from "./facts.ts";
import { VideoPlayer } from "../media/video.ts";
import { HeldMotion } from "../socket/held_motion.ts";
import "./key_card.ts";
import { CommandList } from "./command_list.ts";
import { guardTurn } from "../queue/leave_guard.ts";
import { type Connection, openConnection, isReplay } from "../socket/connection.ts";
import { LogList } from "./log_list.ts";
import { Notice } from "./notice.ts";
import { byId, say } from "../kit/dom.ts";
import { refusal } from "../kit/parts.ts";
import { TurnPanel } from "../queue/turn_panel.ts";
import { type Tolerance, hasLeft, splitPicture, splitState } from "../socket/poses.ts";
import type { CommandInfo, Message, PicturePacket, PlanAnswer, Snapshot, StatePacket, StreamPacket, VideoPacket } from "../socket/protocol.ts";
import { Sound } from "../media/sound.ts";
import "./sticky_stop.ts";
import { StopPress } from "./stop_press.ts";
import { ByteStreams } from "../socket/byte_streams.ts";
import { Suspension } from "../queue/suspension.ts";
import { WireTrace } from "./wire_trace.ts";
import { Subscription } from "../media/subscription.ts";
import { completeConsole } from "./default_console.ts";
import { pictureAge } from "../media/picture_age.ts";
import { watcherWords } from "../queue/waits.ts";
import { COMMAND_LABELS, laterStage, SETTING_KINDS } from "../socket/stages.ts";

const SILENT_MS = 3000;
const AWAY_MS = 20_000; // so long a turn is kept without a connection
const ALONE_MS = 1500; // messages sent together with the robot's last one do not count
Object.assign(COMMAND_LABELS, facts.labels);
for (const kind of facts.settings) SETTING_KINDS.add(kind);

export class RobotPage {
  snapshot: Snapshot | null = null;
  state: StatePacket | null = null;
  readonly slug: string;
  readonly live: Connection;
  readonly ladder: CommandList;
  /** Called with the answer of a preview, on pages that ask for one. */
  onPlan: ((answer: PlanAnswer) => void) | null = null;
  private page = byId("robot");
  private place: TurnPanel;
  private watching: Subscription;
  private trace: WireTrace | null;
  private seq = 0;
  private seqGrant = 0;
  private planned = 0;
  private toldOver = 0; // the socket over which the last snapshot came
  private stateHeardAt = 0;
  private stopPress: StopPress;
  private suspended = new Suspension((words, level) => this.notice(words, level));
  private storeDown = "";
  private watchers: number | null = null; // the driver apart
  private notices = new Notice(byId("notice"));
  private awake = new ScreenWakeLock();
  private calm = matchMedia("(prefers-reduced-motion: reduce)");
  private log = new LogList(byId("log"));
  private console: Console | null = null;
  private film = new VideoPlayer(facts.video, (packet) => this.showPicture(packet), (on) => this.watching.video(on));
  private sound: Sound | null = null;
  private streams = new ByteStreams(facts.streams.map(({ name }) => name));

  constructor() {
    const saving = (navigator as { connection?: { saveData?: boolean } }).connection?.saveData ?? false;
    this.watching = new Subscription(() => this.live, facts.video, saving, isReplay());
    this.slug = this.page.dataset["slug"] ?? "";
    this.ladder = new CommandList(byId("ladder"), byId("say"));
    this.live = openConnection(
      this.slug,
      {
        message: (m) => this.message(m), state: (p) => this.gotState(p), picture: (p) => this.gotPicture(p),
        stream: (p) => this.gotStream(p), video: (p) => this.gotVideo(p), sound: (p) => this.sound?.take(p),
        line: (up) => this.gotLine(up), busy: () => this.facts().busy, took: (bytes) => this.watching.took(bytes),
      },
      () => (this.snapshot?.me.can.drive ? 2000 : 10_000),
      facts.compact, (moved) => this.watching.wish(moved),
    );
    const pace = byId<HTMLSelectElement>("pace");
    pace.value = this.watching.choice;
    pace.addEventListener("change", () => this.watching.choose(pace.value));
    if (document.getElementById("sound"))
      this.sound = new Sound(byId("sound"), byId("sound-said"), byId<HTMLMeterElement>("loudness"), (on) => this.watching.listen(on));
    this.stopPress = new StopPress(this.live, (words, level) => this.notice(words, level));
    this.place = new TurnPanel(byId("place"), (m) => this.live.send(m), (why) => this.refuse(why));
    this.trace = document.getElementById("trace") ? new WireTrace(byId("trace"), byId("trace-rate")) : null;
    for (const control of document.querySelectorAll<HTMLElement>("[data-kind]"))
      control.hidden = !facts.commands.some(({ kind }) => kind === control.dataset["kind"]);
    this.on("stop", () => this.stop());
    this.on("release", () => this.live.send({ t: "release", checked: byId<HTMLInputElement>("checked").checked }));
    byId("stage").addEventListener("keydown", (event) => this.stopKey(event));
    guardTurn(() => this.operating && !this.snapshot?.turn?.staff);
    document.addEventListener("visibilitychange", () => document.hidden || this.watching.again());
    setInterval(() => this.draw(), 250);
  }

  /** Install the console, with defaults for missing members; it is called now with everything that came before. */
  begin(own: Partial<Console>): void {
    const console = (this.console = completeConsole(own, this));
    if (this.live.up) console.watch?.();
    if (console.video) void VideoPlayer.possible(facts.video).then((can) => can && this.watching.video(true));
    if (this.snapshot?.still) console.still(this.snapshot.still);
    if (this.state) console.state(this.state);
    for (const { name } of facts.streams) for (const packet of this.stream(name)) console.stream?.(name, packet);
    this.draw();
  }

  /** Have the pictures of these cameras; a page that never asks gets those of the first one. */
  watch(cameras: number[]): void {
    this.watching.want(cameras);
  }

  /** The newest value of that name: rad, m or the spec's unit; undefined if none has arrived. */
  value(name: string): number | undefined {
    const joint = facts.names.indexOf(name), channel = [...facts.channels, ...facts.pose].findIndex((c) => c.name === name);
    const value = joint < 0 ? this.state?.values[channel] : this.state?.joints[joint];
    return Number.isNaN(value) ? undefined : value;
  }

  /** The newest pose, by coordinates that states carry (m, rad), NaN for one that is not known; empty before the first. */
  get pose(): number[] {
    const first = facts.channels.length;
    return this.state?.values.slice(first, first + facts.pose.length) ?? [];
  }

  /** Whether the robot is no longer where it was at a picture or still, by its pose; no if either is not known. */
  moved(since: { pose?: readonly number[] }, near?: Tolerance): boolean {
    return hasLeft(since.pose ?? [], this.pose, facts.pose.map(({ unit }) => unit), near);
  }

  /** The newest key packet of a byte stream and the deltas after it; empty if none has arrived. */
  stream(name: string): StreamPacket[] {
    return this.streams.of(name);
  }

  /** Why that kind of command does not work now; empty if it does. */
  whyNot(kind: string): string {
    return this.console?.whyNot(kind, this.facts()) ?? blocked(this.facts());
  }

  /** Run `act` at a press of the button, unless it is disabled. */
  on(name: string, act: () => void): void {
    for (const button of document.querySelectorAll<HTMLElement>(`[data-command="${name}"]`))
      button.addEventListener("click", () => {
        if (refusal(button)) return this.refuse(() => refusal(button));
        act();
      });
  }

  /** The part of a held motion that is the same for every control. */
  readonly keepAlive = new HeldMotion({
    send: (m) => this.live.send(m), ended: (seq) => this.ladder.ended(this.seqGrant, seq), refused: (why) => this.refuse(why),
  });

  /** Whether nothing runs that belongs to this page, and its line may carry more than what is shown. */
  get idle(): boolean {
    return this.watching.good && !this.facts().busy;
  }

  get operating(): boolean {
    return this.snapshot?.me.can.drive ?? false;
  }

  /** The number of the newest command of this grant; 0 if there is none. */
  get lastSeq(): number {
    return this.seq;
  }

  get grant(): number {
    return this.seqGrant;
  }

  facts(): Facts {
    return {
      snapshot: this.snapshot, state: this.state, lineUp: !this.live.lost, now: this.live.now(), latency: this.live.latency,
      busy: this.keepAlive.held || (this.seqGrant !== 0 && this.ladder.busy(this.seqGrant, configKinds)),
    };
  }

  /** Give a command, or show why not. Returns its sequence number; 0 if it was not given. */
  command(kind: string, args: object = {}, judged = kind): number {
    if (this.whyNot(judged)) {
      this.refuse(() => this.whyNot(judged));
      return 0;
    }
    return this.issue(kind, args);
  }

  /** Ask where a command would lead from here; `onPlan` gets the answer, with the number that this returns. */
  plan(kind: string, args: object = {}): number {
    this.live.send({ t: "plan", n: ++this.planned, kind, args, from: this.state?.joints ?? [] });
    return this.planned;
  }

  /** When the picture on the page was taken (ms since 1970), which is stored with what is asked for; 0 without one. */
  get seen(): number { return Math.max(0, Math.round(this.console?.pictureAt() ?? 0)); }

  /** Put the next command into the list and send it. Returns its sequence number. */
  issue(kind: string, args: object): number {
    this.seq += 1;
    this.settle();
    this.ladder.update({ id: 0, seq: this.seq, grant: this.seqGrant, kind, state: "sending", reason: "", at_ms: this.live.now(), over: this.live.opened, result: {} });
    performance.mark(`command-${this.seq}`);
    this.live.send({ t: "command", kind, args, seq: this.seq, ...(this.seen ? { seen: this.seen } : {}) });
    if (facts.commands.some((c) => c.kind === kind && c.held)) this.keepAlive.hold(this.seq);
    this.draw();
    return this.seq;
  }

  notice(words: string, level: string): void {
    this.notices.show(words, level);
  }

  /** Say why something is refused, for as long as `why` says so and nothing else is given. */
  refuse(why: () => string): void {
    this.notices.refuse(why);
  }

  /** Something was chosen: what was refused before is over. */
  settle(): void {
    this.notices.settle();
  }

  private stopKey(event: KeyboardEvent): void {
    const field = (event.target as HTMLElement).closest("input, textarea, select, [contenteditable]");
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey || !this.snapshot?.me.can.stop) return;
    if (event.key !== "Escape" && (event.key.toLowerCase() !== "s" || field)) return;
    event.preventDefault();
    this.stop();
  }

  private stop(): void {
    this.stopPress.press();
    this.draw();
  }

  private gotLine(up: boolean): void {
    if (up) {
      this.watching.opened();
      this.console?.watch?.();
      this.watching.tell();
    }
    this.draw();
  }

  private gotVideo(packet: VideoPacket): void {
    this.watching.arrived(packet, packet.coded.length);
    this.film.take(packet);
  }

  private gotPicture(packet: PicturePacket): void {
    this.watching.arrived(packet, packet.jpeg.size);
    this.showPicture(splitPicture(packet, facts.names.length, facts.pose.length));
  }

  /** With reduced motion, people who only watch get stills and one live picture every ten seconds. */
  private showPicture(packet: PicturePacket): void {
    const shown = this.console?.shown(packet.camera);
    const still = this.snapshot?.still;
    const placed = packet.pose?.length || !still || still.id !== packet.still ? packet : { ...packet, pose: still.pose };
    if (this.calm.matches && !this.operating && !isReplay() && shown && skipsForReducedMotion(packet, shown)) return;
    this.console?.picture(placed);
  }

  /** Compact states lack velocities and torques; a whole one between them must not show them for a moment. */
  private gotState(whole: StatePacket): void {
    const told = splitState(whole, facts.channels.length + facts.pose.length);
    const packet = this.watching.pace === "live" ? told : { ...told, velocities: [], torques: [], twist: [] };
    this.state = packet;
    this.stateHeardAt = performance.now();
    this.console?.state(packet);
  }

  private gotStream(packet: StreamPacket): void {
    const name = this.streams.take(packet);
    if (name !== undefined) this.console?.stream?.(name, packet);
  }

  private message(m: Message): void {
    if (m.t === "snapshot") this.gotSnapshot(m);
    else if (m.t === "command") this.gotCommand(m);
    else if (m.t === "answer") {
      const said = m.to === "stop" && this.stopPress.answered(m.ok);
      if (!m.ok && m.to === "command") this.ladder.refuse(this.seqGrant, m.seq ?? 0, m.text, this.live.now());
      if (m.ok) this.settle();
      const checked = byId<HTMLInputElement>("checked"), unchecked = m.to === "release" && !checked.checked;
      if (m.text && !said && m.ok) this.notices.show(m.text, "info", m.to === "stop" ? () => byId("release").hidden === true : undefined);
      else if (m.text && !said) this.refuse(() => (unchecked && checked.checked ? "" : m.text));
    } else if (m.t === "notice") this.notice(m.text, m.level);
    else if (m.t === "plan") this.onPlan?.(m);
    else if (m.t === "trace") this.trace?.add(m);
    else if (m.t === "store") this.storeDown = m.text;
    else if (m.t === "watchers") this.watchers = m.count;
    else if (m.t === "pong" && this.snapshot) this.snapshot.link = m.link;
    this.draw();
  }

  private gotSnapshot(s: Snapshot): void {
    const wasOperating = this.operating;
    const hadStill = this.snapshot?.still?.id;
    const before = new Map(this.snapshot?.commands.map((c) => [c.id, c]));
    if (!s.replay) s.commands = s.commands.map((c) => laterStage(before.get(c.id), c)); // it may have been read earlier
    this.snapshot = s;
    this.toldOver = this.live.opened;
    this.storeDown = s.store;
    if (s.turn && s.turn.grant !== this.seqGrant) {
      this.seqGrant = s.turn.grant;
      this.seq = s.turn.next_seq - 1;
      this.console?.turn();
    } else if (s.turn) this.seq = Math.max(this.seq, s.turn.next_seq - 1);
    if (s.replay) this.ladder.clear();
    this.ladder.reset(s.commands);
    this.place.changed(s);
    if (s.still && s.still.id !== hadStill) this.console?.still(s.still);
    if (this.trace && s.me.staff) this.live.send({ t: "trace", on: true });
    const end = wasOperating && !s.me.can.drive ? s.me.last_end : null;
    if (end) this.notice(`Your turn is over. ${end.why}`, end.own ? "info" : "warning");
    if (!wasOperating && s.me.can.drive) byId("screen").focus({ preventScroll: true });
    this.log.draw(s.log, this.live.now());
    this.stopPress.heard(s); // last, because the result of a Stop matters most
  }

  private gotCommand(m: { t: "command" } & CommandInfo): void {
    this.ladder.update(m);
    document.dispatchEvent(new Event("farhand:acted"));
    if (this.snapshot) this.snapshot.commands = [m, ...this.snapshot.commands.filter((c) => c.id !== m.id)].slice(0, 8);
    this.console?.command(m);
  }

  draw(): void {
    const f = this.facts();
    this.drawBanner(f);
    this.drawAge(f);
    this.notices.draw();
    this.awake.keep(this.operating && !isReplay() && this.live.lostMs < AWAY_MS);
    const s = this.snapshot;
    this.ladder.lost(this.toldOver, this.live.now());
    if (s ? s.me.can.drive && s.link && !f.busy : this.page.dataset["drives"] !== undefined) this.live.operate?.();
    if (!s) return;
    this.page.dataset["state"] = s.robot.state;
    this.page.classList.toggle("operating", s.me.can.drive);
    say(byId("state"), s.robot.label);
    say(byId("why-state"), s.robot.why);
    const driven = s.operator ? `${s.operator} drives` : s.robot.turns === false ? "" : "Nobody drives";
    say(byId("operator"), driven);
    say(byId("watchers"), this.watchers === null || s.replay ? "" : `, ${watcherWords(this.watchers, s.me.can.drive)}`);
    say(byId("queue"), s.queue === 0 ? (driven ? "nobody waits" : "Nobody waits") : `${s.queue} waiting`);
    const who = byId("operator").parentElement as HTMLElement;
    const rest = `${byId("queue").textContent}${byId("watchers").textContent}`;
    who.title = driven ? `${driven}, ${rest}` : rest; // a narrow window cuts it
    this.place.draw(s, this.live.now(), f.lineUp);
    this.suspended.draw(s, f.lineUp);
    byId("controls").hidden = !s.me.can.drive && !s.me.can.stop;
    byId("release").hidden = !(s.stopped || f.state?.stopped) || !s.me.can.stop;
    say(byId("stop-said"), unconfirmedStop(s.stop, f.now) ? "Stop is pressed" : "The robot is stopped");
    say(byId("why"), blocked(f) || (this.console?.advice(f) ?? ""));
    byId("why").title = byId("why").textContent ?? "";
    this.console?.draw(f);
  }

  private drawBanner(f: Facts): void {
    const banner = byId("banner");
    const s = this.snapshot;
    const words = bannerWords({
      lost: !f.lineUp, lostMs: this.live.lostMs, offline: !navigator.onLine, snapshot: s, storeDown: this.storeDown,
      stopPending: this.stopPress.pending, robotSilent: this.robotSilent(f), now: f.now,
    });
    if (words && !banner.textContent) this.notices.hide(); // the banner is newer
    say(banner, words);
    banner.hidden = !words;
  }

  /** The robot is silent if the portal was heard after its last message; without a connection nothing is known. */
  private robotSilent(f: Facts): boolean {
    const old = this.state !== null && f.now - this.state.atMs > SILENT_MS && this.snapshot?.robot.state !== "offline";
    return old && this.live.heardSince(this.stateHeardAt + ALONE_MS);
  }

  private drawAge(f: Facts): void {
    const at = this.console?.pictureAt() ?? 0;
    const age = at ? f.now - at : Infinity;
    const badge = byId("age");
    const rate = age < SILENT_MS ? this.watching.rate() : 0;
    const often = rate ? `, ${rate < 9.5 ? rate.toFixed(1) : Math.round(rate)} a second` : "";
    const [words, mark] = pictureAge(age, often);
    say(badge, at ? words : facts.cameras ? "No picture yet" : "");
    badge.dataset["age"] = mark;
    say(byId("pace-said"), this.watching.said(facts.cameras > 0 && f.snapshot?.robot.state !== "offline"));
    say(byId("line-said"), this.watching.lineSaid());
    this.sound?.draw(this.watching.soundless);
    say(byId("latency"), this.live.latency === null ? "" : `${Math.round(this.live.latency)} ms`);
  }
}
