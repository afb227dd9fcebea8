/** The page of every robot: it owns the connection, the newest snapshot and state, and the parts that show them. */
import { byId, say } from "../kit/dom.ts";
import { every } from "../kit/page_clock.ts";
import { refusal } from "../kit/refusal.ts";
import { focusStage } from "../kit/stage_focus.ts";
import { ScreenWakeLock } from "../kit/wake_lock.ts";
import { gettext, translate } from "../kit/text.ts";
import { guardTurn } from "../queue/leave_guard.ts";
import { Suspension } from "../queue/suspension.ts";
import { TurnPanel } from "../queue/turn_panel.ts";
import { type Connection, isReplay, openConnection } from "../socket/connection.ts";
import { type CommandLayout, type CommandMessage, packCommand, packHold, packPing } from "../socket/command_packet.ts";
import type { Answer, CommandInfo, Message, PlanAnswer, Snapshot } from "../socket/messages.ts";
import type { StatePacket, StreamPacket } from "../socket/packets.ts";
import type { Tolerance } from "../socket/poses.ts";
import { COMMAND_LABELS, SETTING_KINDS } from "../socket/stages.ts";
import { bannerWords, showBanner } from "./banner.ts";
import { Cheers } from "./cheers.ts";
import type { CommandList } from "./command_list.ts";
import { Commands, latestStages } from "./commands.ts";
import { completeConsole, type Console } from "./console.ts";
import { blocked, type Facts } from "./controls.ts";
import { facts } from "./facts.ts";
import "./key_card.ts";
import { keys } from "./keys.ts";
import { drawLog } from "./log_list.ts";
import { Media } from "./media.ts";
import { Notice } from "./notice.ts";
import { RobotState } from "./robot_state.ts";
import { Stage } from "./stage.ts";
import { Status } from "./status.ts";
import { StopButton } from "./stop_button.ts";
import { targetOf } from "./target.ts";
import { WayBack } from "./way_back.ts";
import { WireTrace } from "./wire_trace.ts";

const AWAY_MS = 20_000; // a turn is kept for so long without a connection
Object.assign(COMMAND_LABELS, facts.labels);
for (const kind of facts.settings) SETTING_KINDS.add(kind);

export class RobotPage {
  snapshot: Snapshot | null = null;
  readonly slug: string;
  readonly live: Connection;
  /** Called with the answer of a preview, on pages that ask for one. */
  onPlan: ((answer: PlanAnswer) => void) | null = null;
  private page = byId("robot");
  private console: Console | null = null;
  private commands = new Commands(this);
  private media = new Media({ connection: () => this.live, console: () => this.console, snapshot: () => this.snapshot });
  private notices = new Notice(byId("notice"));
  private status = new Status();
  private cheers = document.getElementById("cheer") ? new Cheers(() => this.live.send({ t: "cheer" }), this) : null;
  private suspension = new Suspension((words, level) => this.notice(words, level));
  private wakeLock = new ScreenWakeLock();
  private stop: StopButton;
  private turnPanel: TurnPanel;
  private trace: WireTrace | null;
  private robot = new RobotState();
  private storeDown = "";
  private ways: WayBack[] = [];

  constructor() {
    const { media } = this;
    this.slug = this.page.dataset["slug"] ?? "";
    new Stage(this.slug);
    this.live = openConnection(
      this.slug,
      {
        ...media.handlers,
        message: (m) => this.message(m),
        state: (p) => this.gotState(p),
        path: (p) => this.console?.path?.(p),
        line: (up) => this.gotLine(up),
        busy: () => this.facts().busy,
      },
      () => (this.operating ? 2000 : 10_000),
      facts.compact,
      (moved) => media.subscription.wish(moved),
      (message) => (this.thin && facts.packed ? this.packed(facts.packed, message) : null),
      () => media.subscription.inPieces,
    );
    this.stop = new StopButton({
      connection: this.live,
      on: (name, act) => this.on(name, act),
      notice: (words, level) => this.notice(words, level),
      snapshot: () => this.snapshot,
      draw: () => this.draw(),
    });
    this.turnPanel = new TurnPanel(byId("place"), this, "take" in byId("robot").dataset);
    this.trace = document.getElementById("trace") ? new WireTrace(byId("trace"), byId("trace-rate")) : null;
    for (const control of document.querySelectorAll<HTMLElement>("[data-kind]"))
      if (!facts.commands.some(({ kind }) => kind === control.dataset["kind"])) control.hidden = true;
    guardTurn(() => this.operating && !this.snapshot?.turn?.staff);
    every(250, () => this.draw());
  }

  /** Install the console, with defaults for missing members, and give it everything that has come so far. */
  begin(own: Partial<Console>): void {
    const console = (this.console = completeConsole(own, this));
    if (this.live.up) console.watch?.();
    this.media.begin(console);
    this.media.still();
    if (this.state) console.state(this.state);
    for (const { name } of facts.streams) for (const packet of this.stream(name)) console.stream?.(name, packet);
    this.draw();
  }

  /** Ask for the pictures of these cameras; a page that never asks gets those of the first one. */
  watch(cameras: number[]): void {
    this.media.subscription.want(cameras);
  }

  /** The newest state; null before the first. */
  get state(): StatePacket | null {
    return this.robot.packet;
  }

  /** Return the newest value of that name, in rad, m or the spec's unit; undefined before the first. */
  value(name: string): number | undefined {
    return this.robot.value(name);
  }

  /** The newest pose by the spec's coordinates (m, rad), NaN for one that is not known; empty before the first. */
  get pose(): number[] {
    return this.robot.pose;
  }

  /** Return whether the robot has left the pose of a picture or still; no if either pose is not known. */
  moved(since: { pose?: readonly number[] }, near?: Tolerance): boolean {
    return this.robot.hasLeft(since.pose ?? [], near);
  }

  /** Return the newest key packet of a byte stream and the deltas after it; empty before the first. */
  stream(name: string): StreamPacket[] {
    return this.media.stream(name);
  }

  /** Return why that kind of command does not work now; empty if it does. */
  whyNot(kind: string): string {
    return this.console?.whyNot(kind, this.facts()) ?? blocked(this.facts());
  }

  /** Run `act` at a press of the buttons of that name; a disabled one shows its reason instead. */
  on(name: string, act: () => void): void {
    for (const button of document.querySelectorAll<HTMLElement>(`[data-command="${name}"]`))
      button.addEventListener("click", () => {
        if (refusal(button)) this.refuse(() => refusal(button));
        else act();
      });
  }

  /** Return the action of a pressed key, by `data-action` of the list of keys; empty if it has none. */
  keyAction(event: KeyboardEvent): string {
    return keys.action(event);
  }

  /** The part of a held motion that is the same for every control. */
  readonly keepAlive = this.commands.heldMotion;
  readonly ladder: CommandList = this.commands.list;

  /** Whether no command of this page runs, and its line brings everything in time. */
  get idle(): boolean {
    return this.media.subscription.good && !this.facts().busy;
  }

  get operating(): boolean {
    return this.snapshot?.me.can.drive ?? false;
  }

  /** Where the command that runs takes the robot, for people who watch it live or recorded; null for who drives. */
  get target(): ReturnType<typeof targetOf> {
    const s = this.snapshot,
      known = s !== null && s.link && s.robot.state !== "offline" && !this.live.lost;
    return known && !this.operating ? targetOf(s.commands) : null;
  }

  /** Remember from now on where the robot was before the last move of these kinds, in this turn. */
  wayBack(kinds: readonly string[], here: () => readonly number[]): WayBack {
    const way = new WayBack(kinds, here);
    this.ways.push(way);
    return way;
  }

  /** The number of the newest command of this grant; 0 if there is none. */
  get lastSeq(): number {
    return this.commands.seq;
  }

  get grant(): number {
    return this.commands.grant;
  }

  facts(): Facts {
    return {
      snapshot: this.snapshot,
      state: this.state,
      lineUp: !this.live.lost,
      now: this.live.now(),
      latency: this.live.latency,
      busy: this.commands.busy,
    };
  }

  /** Send a command, or show why it does not work now. Returns its sequence number; 0 if it was not sent. */
  command(kind: string, args: object = {}, judged = kind): number {
    if (this.whyNot(judged)) {
      this.refuse(() => this.whyNot(judged));
      return 0;
    }
    return this.issue(kind, args);
  }

  /** Ask where a command would lead from here. Returns the number of the answer, which `onPlan` gets. */
  plan(kind: string, args: object = {}): number {
    return this.commands.plan(kind, args, this.state?.joints ?? []);
  }

  /** When the picture on the page was taken (ms since 1970; 0 without one); it is stored with each command. */
  get seen(): number {
    return Math.max(0, Math.round(this.console?.pictureAt() ?? 0));
  }

  /** Put the next command into the list and send it. Returns its sequence number. */
  issue(kind: string, args: object): number {
    this.settle();
    const seq = this.commands.issue(kind, args, this.seen);
    for (const way of this.ways) way.take({ seq, kind, grant: this.grant, state: "sending" });
    this.draw();
    return seq;
  }

  notice(words: string, level: string): void {
    this.notices.show(words, level);
  }

  /** Show why something is refused, for as long as `why` returns the same and no command is sent. */
  refuse(why: () => string): void {
    this.notices.refuse(why);
  }

  /** Hide the last refusal: the person has chosen something else. */
  settle(): void {
    this.notices.settle();
  }

  /** Whether the line is thin, so that nothing large is loaded unless somebody asks for it. */
  get thin(): boolean {
    return this.media.subscription.pace !== "live";
  }

  /** Return a message in few bytes; null if it is sent as JSON. */
  private packed(layout: CommandLayout, message: object): Uint8Array<ArrayBuffer> | null {
    const { t = "", seq = 0, n = 0 } = message as { t?: string; seq?: number; n?: number };
    if (t === "ping") return packPing(n);
    if (t === "command") return packCommand(layout, message as CommandMessage, this.live.now());
    return t === "keep" || t === "released" ? packHold(layout, this.keepAlive.kindOf(seq), { ...message, t, seq }) : null;
  }

  private gotLine(up: boolean): void {
    if (up) {
      this.media.subscription.opened();
      this.console?.watch?.();
      this.media.subscription.tell();
    }
    this.draw();
  }

  private gotState(whole: StatePacket): void {
    this.console?.state(this.robot.take(whole, this.media.subscription.pace === "live"));
  }

  private message(m: Message): void {
    if (m.t === "snapshot") this.gotSnapshot(m);
    else if (m.t === "command") this.gotCommand(m);
    else if (m.t === "answer") this.gotAnswer(m);
    else if (m.t === "notice") this.notice(translate(m.text), m.level);
    else if (m.t === "plan") this.onPlan?.(m);
    else if (m.t === "trace") this.trace?.add(m);
    else if (m.t === "store") this.storeDown = m.text;
    else if (m.t === "watchers") this.status.watchers = m.count;
    else if (m.t === "cheers") this.cheers?.take(m);
    // eslint-disable-next-line @typescript-eslint/no-unnecessary-condition -- a newer portal may send others
    else if (m.t === "pong" && this.snapshot) this.snapshot.link = m.link;
    this.draw();
  }

  private gotAnswer(m: Answer): void {
    const late = m.to === "stop" && this.stop.press.answer(m.ok);
    if (!m.ok && m.to === "command") this.refused(m);
    if (!m.ok && (m.to === "join" || m.to === "accept")) this.turnPanel.refused();
    if (m.to === "cheer") this.cheers?.answer(m.ok);
    if (m.ok && m.to !== "command") this.settle(); // a command has done so when it was sent
    const unchecked = m.to === "release" && !this.stop.looked;
    if (!m.text || late) return;
    if (m.ok) this.notices.show(translate(m.text), "info", m.to === "stop" ? () => byId("release").hidden === true : undefined);
    else this.refuse(() => (unchecked && this.stop.looked ? "" : translate(m.text)));
  }

  private refused(m: Answer): void {
    this.commands.refused(m);
    for (const way of this.ways) way.take({ seq: m.seq ?? 0, grant: this.grant, kind: "", state: "rejected" });
  }

  private gotSnapshot(s: Snapshot): void {
    const wasOperating = this.operating,
      maintained = wasOperating && this.snapshot?.turn?.staff === true,
      hadStill = this.snapshot?.still?.id;
    if (!s.replay) s.commands = latestStages(s.commands, this.snapshot?.commands);
    this.snapshot = s;
    this.storeDown = s.store;
    const another = this.commands.follow(s);
    for (const way of this.ways) {
      way.turn(s.me.can.drive ? this.grant : 0);
      for (const c of s.commands) way.take(c);
    }
    if (another) this.console?.turn();
    this.commands.show(s);
    this.turnPanel.changed(s);
    if (s.still?.id !== hadStill) this.media.still();
    if (this.trace && s.me.staff) this.live.send({ t: "trace", on: true });
    const end = wasOperating && !maintained && !s.me.can.drive ? s.me.last_end : null;
    if (end) this.notice(gettext("Your turn is over. {why}", { why: translate(end.why) }), end.own ? "info" : "warning");
    if (maintained && !s.me.can.drive) this.maintenanceEnded(s);
    if (!wasOperating && s.me.can.drive) focusStage();
    drawLog(byId("log"), s.log, this.live.now());
    this.stop.press.update(s); // last, because the result of a Stop matters most
  }

  /** Say that the maintenance turn is over, whoever ended it, and take away what was said as it began. */
  private maintenanceEnded({ robot }: Snapshot): void {
    document.querySelector(".messages:not(:has(form))")?.remove();
    const shut = gettext("The maintenance turn is over. The robot stays locked out.");
    this.notice(robot.state === "locked_out" ? shut : gettext("Your turn is over. {why}", { why: translate(robot.why) }), "warning");
  }

  private gotCommand(m: { t: "command" } & CommandInfo): void {
    this.commands.list.update(m);
    for (const way of this.ways) way.take(m);
    document.dispatchEvent(new Event("farhand:acted"));
    if (this.snapshot) this.snapshot.commands = [m, ...this.snapshot.commands.filter((c) => c.id !== m.id)].slice(0, 8);
    this.console?.command(m);
  }

  draw(): void {
    const f = this.facts(),
      s = this.snapshot;
    const words = bannerWords({
      lost: !f.lineUp,
      lostMs: this.live.lostMs,
      offline: !navigator.onLine,
      snapshot: s,
      storeDown: this.storeDown,
      stopPending: this.stop.press.pending,
      robotSilent: s?.robot.state !== "offline" && this.robot.silent(f.now, (at) => this.live.heardSince(at)),
      now: f.now,
    });
    showBanner(words, () => this.notices.hide()); // the banner is newer
    this.media.draw(f);
    this.notices.draw();
    this.wakeLock.keep(this.operating && !isReplay() && this.live.lostMs < AWAY_MS);
    this.commands.draw();
    if (s ? s.me.can.drive && s.link && !f.busy : this.page.dataset["drives"] !== undefined) this.live.operate?.();
    say(byId("target"), translate(this.target?.words ?? ""));
    if (!s) return;
    this.turnPanel.draw(s, f.now, f.lineUp);
    this.suspension.draw(s, f.lineUp);
    this.cheers?.draw(s, f.lineUp);
    this.status.draw(s, f, (now) => this.console?.advice(now) ?? "");
    this.console?.draw(f);
  }
}
