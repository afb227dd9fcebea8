/** Long messages over a thin line come in pieces; what is not whole is never read. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { Pieces, TEXT_PIECE, TextPieces } from "../src/socket/pieces.ts";
import { bytesOf, vectorsOf } from "./helpers.ts";

interface Cut {
  what: string;
  message: string;
  pieces: string[];
}
const hex = (data: ArrayBuffer | null): string | null => data && Buffer.from(data).toString("hex");

test("a message is whole with its last piece, as Python cuts it", () => {
  const pieces = new Pieces();
  for (const { what, message, pieces: cut } of vectorsOf<Cut[]>("pieces")) {
    const read = cut.map((piece) => hex(pieces.take(bytesOf(piece).buffer)));
    assert.deepEqual(read, [...cut.slice(1).map(() => null), message], what);
  }
});

test("the first piece of another message drops the one before, and pieces without a first one are dropped", () => {
  const pieces = new Pieces();
  const take = (...bytes: number[]): string | null => hex(pieces.take(new Uint8Array(bytes).buffer));
  assert.equal(take(7, 2, 9), null, "a last one alone");
  assert.equal(take(7, 1, 1), null);
  assert.equal(take(7, 1, 2), null);
  assert.equal(take(7, 2, 3), "0203");
  assert.equal(take(7, 2, 3), null, "it is read once");
  assert.equal(take(7), null);
  assert.equal(take(7, 1, 4), null);
  pieces.clear();
  assert.equal(take(7, 2, 5), null, "another socket");
});

test("a message without an end takes no more than 4 MiB", () => {
  const pieces = new Pieces(),
    part = new Uint8Array(1 << 20).fill(0);
  part[1] = 1;
  pieces.take(part.buffer);
  for (let i = 0; i < 5; i++) assert.equal(pieces.take(new Uint8Array(1 << 20).buffer), null);
  const last = new Uint8Array([7, 2]);
  assert.equal(pieces.take(last.buffer), null);
});

test("a text is whole with its last piece, as Python cuts it; what is not whole is never read", () => {
  const texts = new TextPieces();
  for (const { what, message, pieces: cut } of vectorsOf<Cut[]>("text_pieces")) {
    const read = cut.map((piece) => (piece.startsWith(TEXT_PIECE) ? texts.take(piece) : piece));
    assert.deepEqual(read, [...cut.slice(1).map(() => null), message], what);
  }
  assert.equal(texts.take("\u00072end"), null, "a last one alone");
  assert.equal(texts.take("\u00071of one"), null);
  assert.equal(texts.take("\u00071of "), null);
  assert.equal(texts.take("\u00072another"), "of another");
  assert.equal(texts.take("\u00071a"), null);
  texts.clear();
  assert.equal(texts.take("\u00072b"), null, "another socket");
  for (const broken of ["\u0007", "\u0007x", "\u0007-1a"]) assert.equal(texts.take(broken), null);
  texts.take(`\u00071${"a".repeat(4 << 20)}`);
  assert.equal(texts.take("\u00072b"), null, "longer than 4 MiB");
});
