/** Which of a camera's pictures is newer. */
const BACK_MS = 5000; // a picture that was taken so much earlier comes after the server's clock was set back

/** The order of a camera's pictures, by when they were taken: numbers begin again when the robot's process does. */
export class PictureOrder {
  private newest: { atMs: number; number: number } | null = null;

  /** Whether this picture is newer than all before it, and the newest from now on. */
  take(picture: { atMs: number; number: number; first?: boolean }): boolean {
    const { newest } = this;
    if (newest && !picture.first && !this.follows(picture, newest)) return false;
    this.newest = { atMs: picture.atMs, number: picture.number };
    return true;
  }

  private follows(picture: { atMs: number; number: number }, newest: { atMs: number; number: number }): boolean {
    const laterMs = picture.atMs - newest.atMs;
    if (laterMs === 0) return picture.number > newest.number;
    return laterMs > 0 || laterMs < -BACK_MS;
  }

  /** Whether no newer picture was taken since this one. */
  holds(picture: { atMs: number; number: number }): boolean {
    return this.newest?.atMs === picture.atMs && this.newest.number === picture.number;
  }

  forget(): void {
    this.newest = null;
  }
}
