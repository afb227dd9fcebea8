/** Puts long messages together that come in pieces over a thin line, bytes and texts (portal/live/pieces.py). */

const HEAD = 2,
  FIRST = 1,
  LAST = 2,
  MOST = 4 << 20; // bytes of a message
/** The first byte of a piece. */
export const PIECE = 7;

export class Pieces {
  private parts: Uint8Array[] = [];
  private size = 0;
  private open = false;

  /** Take a piece. Returns the message whose last piece it is; null for every other, and for one whose first is missing. */
  take(data: ArrayBuffer): ArrayBuffer | null {
    const bytes = new Uint8Array(data),
      flags = bytes[1] ?? 0;
    if (flags & FIRST) this.clear(true);
    this.size += bytes.length - HEAD;
    if (bytes.length < HEAD || this.size > MOST) this.clear(false);
    if (!this.open) return null;
    this.parts.push(bytes.subarray(HEAD));
    if (!(flags & LAST)) return null;
    const whole = new Uint8Array(this.size);
    let at = 0;
    for (const part of this.parts) {
      whole.set(part, at);
      at += part.length;
    }
    this.clear(false);
    return whole.buffer;
  }

  /** Forget what came of a message; `open`: pieces of another follow. */
  clear(open = false): void {
    [this.parts, this.size, this.open] = [[], 0, open];
  }
}

/** The first character of a piece of a text. */
export const TEXT_PIECE = "\u0007";

export class TextPieces {
  private text = "";
  private open = false;

  /** Take a piece. Returns the text whose last piece it is; null for every other, and for one whose first is missing. */
  take(piece: string): string | null {
    const flags = Number(piece[1]);
    if (flags & FIRST) [this.text, this.open] = ["", true];
    if (!this.open) return null;
    this.text += piece.slice(HEAD);
    const whole = this.text;
    if (flags & LAST || whole.length > MOST) this.clear();
    return flags & LAST && whole.length <= MOST ? whole : null;
  }

  /** Forget what came of a text. */
  clear(): void {
    [this.text, this.open] = ["", false];
  }
}
