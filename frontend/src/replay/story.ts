/** The commands and events of a recording: what was known of them at a moment, and the moments to jump to. */
import type { CommandInfo, JobInfo, Snapshot } from "../socket/messages.ts";
import { FINAL, COMMAND_LABELS, stageOf } from "../socket/stages.ts";
import { gettext, translate } from "../kit/text.ts";

type Stage = CommandInfo & { after_ms: number; args?: Record<string, number> };
interface Told {
  after_ms: number;
  what: string;
  text: string;
  level: string;
}
export interface Index {
  began_ms: number;
  ended_ms: number;
  end: string;
  needs: number[];
  cameras: number[];
  pictures: number;
  commands: Stage[];
  events: Told[];
}
export interface About {
  index: string;
  slices: string;
  slug: string;
  name: string;
  who: string;
  /** where the replay opens (ms), and what to say of the link */
  start?: number;
  said?: string;
}
/** A moment that people jump to. `bad`: something failed, or is missing. */
export interface Mark {
  at: number;
  text: string;
  bad: boolean;
}

const SHOWN = 8;

export class Story {
  private index: Index;
  private about: About;

  constructor(index: Index, about: About) {
    this.index = index;
    this.about = about;
  }

  /** Return the stages and events after one moment until another. */
  between(from: number, to: number): { commands: Stage[]; events: Told[] } {
    const within = ({ after_ms: at }: { after_ms: number }): boolean => at > from && at <= to;
    return { commands: this.index.commands.filter(within), events: this.index.events.filter(within) };
  }

  /** Return the snapshot of a moment. */
  snapshot(at: number, stopped: boolean): Snapshot {
    const known = new Map<number, Stage>();
    for (const stage of this.index.commands)
      if (stage.after_ms <= at && !FINAL.has(known.get(stage.id)?.state ?? "")) known.set(stage.id, { ...known.get(stage.id), ...stage });
    const commands = [...known.values()].sort((a, b) => b.id - a.id);
    const { slug, name, who } = this.about;
    return {
      t: "snapshot",
      now_ms: this.index.began_ms + at,
      link: true,
      store: "",
      replay: true,
      robot: { slug, name, state: "operating", label: gettext("Recording"), why: "", turns: true },
      stopped,
      suspended: false,
      stop: null,
      operator: who || null,
      queue: 0,
      turn: null,
      still: null,
      before: null,
      log: [],
      jobs: commands.filter(({ state }) => !FINAL.has(state)).map(job),
      me: { signed_in: false, cleared: false, ticket: null, can: { watch: true, drive: false, ask: false, stop: false } },
      commands: commands.slice(0, SHOWN),
    };
  }

  /** Return the moments to jump to: the begin and a bad end of each command, and events. */
  marks(): Mark[] {
    const begun = new Set<number>();
    const marks = this.index.commands.flatMap((stage): Mark[] => {
      const name = COMMAND_LABELS[stage.kind] ?? stage.kind;
      if (!begun.has(stage.id)) {
        begun.add(stage.id);
        return [{ at: stage.after_ms, text: name, bad: false }];
      }
      const bad = FINAL.has(stage.state) && stage.state !== "completed";
      return bad ? [{ at: stage.after_ms, text: `${name}: ${stageOf(stage.kind, stage.state)}. ${translate(stage.reason)}`, bad }] : [];
    });
    const told = this.index.events.map(({ after_ms: at, text, level }) => ({ at, text: translate(text), bad: level !== "info" }));
    return [...marks, ...told].sort((a, b) => a.at - b.at);
  }
}

function job(stage: Stage): JobInfo {
  return { id: stage.id, kind: stage.kind, state: "running", args: stage.args ?? {}, ahead: 0, wait_s: null };
}
