/** The operator's stream: a second socket beside the public one, opened with a fresh one-time code each time. */
import { OPEN_MS, openSocket, request } from "../kit/request.ts";

const PROTOCOL = "farhand.operator";
const FIRST_MS = 5000,
  LONGEST_MS = 60_000; // between two attempts
/** The close code of a stream whose turn is over or whose code was refused. */
export const STREAM_OVER = 4410;

export class OperatorStream {
  private after = 0; // the next attempt, performance.now
  private pauseMs = FIRST_MS;
  private trying = false;
  private slug: string;
  private token: string;

  /** `token`: against forged requests, from one of the page's forms. */
  constructor(slug: string, token: string) {
    this.slug = slug;
    this.token = token;
  }

  /** Allow the next attempt at once: there is a connection again. */
  soon(): void {
    this.after = 0;
    this.pauseMs = FIRST_MS;
  }

  /**
   * Open the stream, unless an attempt runs or failed a short time ago. `query` is called once there is a code; `began`
   * gets the socket with its first message, and returns whether the page uses it.
   */
  async open(query: () => string, began: (socket: WebSocket, first: MessageEvent) => boolean): Promise<void> {
    if (this.trying || performance.now() < this.after) return;
    this.trying = true;
    const code = await this.code();
    if (code === null) {
      this.failed();
      return;
    }
    const socket = openSocket(`/ws/operators/${this.slug}/${query()}`, [PROTOCOL, code]);
    const late = setTimeout(() => socket.close(), OPEN_MS); // also for one that opens and stays silent
    socket.onclose = () => {
      clearTimeout(late);
      this.failed();
    };
    socket.onmessage = (first) => {
      clearTimeout(late);
      socket.onclose = socket.onmessage = null;
      if (began(socket, first)) {
        this.trying = false;
        this.soon();
      } else {
        socket.close();
        this.failed();
      }
    };
  }

  /** Return a fresh code; null without a connection or a turn. */
  private async code(): Promise<string | null> {
    try {
      const answer = await request(`/robots/${this.slug}/stream-code/`, {
        method: "POST",
        headers: { "X-CSRFToken": this.token },
        redirect: "manual",
      });
      return (answer.ok && ((await answer.json()) as { code: string }).code) || null;
    } catch {
      return null;
    }
  }

  private failed(): void {
    this.trying = false;
    this.after = performance.now() + this.pauseMs * (0.5 + Math.random());
    this.pauseMs = Math.min(LONGEST_MS, 2 * this.pauseMs);
  }
}
