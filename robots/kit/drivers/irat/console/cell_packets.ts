/** Reads the byte stream `cells`: the activity of the pose cells, in levels. */
export const ACROSS = 15;
export const HEADINGS = 36;
export const LEVELS = 7;

export class PoseCells {
  /** The activity of each cell, 0 to 7, by its number: (heading * 15 + y) * 15 + x. */
  levels = new Uint8Array(ACROSS * ACROSS * HEADINGS);

  /** Take a key packet or a delta. Returns false for one that cannot be read; after that only a key packet helps. */
  take(data: Uint8Array, key: boolean): boolean {
    if (data.byteLength % 2) return false;
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    if (key) this.levels.fill(0);
    for (let at = 0; at < data.byteLength; at += 2) {
      const told = view.getUint16(at, true);
      if (told >> 3 >= this.levels.length) return false;
      this.levels[told >> 3] = told & 7;
    }
    return true;
  }
}
