/** The rooms of `src/` import one way only: there is no circle of folders and none of files. */
import assert from "node:assert/strict";
import { globSync, readFileSync } from "node:fs";
import { dirname, relative, resolve } from "node:path";
import { test } from "node:test";

const SRC = resolve(import.meta.dirname, "../src");
// each form of importing: import .. from, export .. from, import "..", import("..")
const IMPORTED = /(?:\bfrom|\bimport)\s*\(?\s*["'](\.[^"']+\.ts)["']/g;
type Graph = Map<string, Set<string>>;

/** The files that a script names in its imports; imports of types count, too. */
function imported(file: string, text: string): string[] {
  return [...text.matchAll(IMPORTED)].map(([, name = ""]) => relative(SRC, resolve(SRC, dirname(file), name)));
}

function files(): Graph {
  const names = globSync("**/*.ts", { cwd: SRC });
  return new Map(names.map((name) => [name, new Set(imported(name, readFileSync(resolve(SRC, name), "utf-8")))]));
}

/** The same graph of the folders directly below `src/`. */
function rooms(graph: Graph): Graph {
  const room = (file: string): string => file.split("/")[0] ?? "";
  const found: Graph = new Map();
  for (const [file, others] of graph) {
    const to = found.get(room(file)) ?? new Set();
    for (const other of others) if (room(other) !== room(file)) to.add(room(other));
    found.set(room(file), to);
  }
  return found;
}

/** A circle as the names along it; null if there is none. */
function circle(graph: Graph): string[] | null {
  const done = new Set<string>();
  const follow = (name: string, path: string[]): string[] | null => {
    if (path.includes(name)) return [...path.slice(path.indexOf(name)), name];
    if (done.has(name)) return null;
    for (const next of graph.get(name) ?? []) {
      const found = follow(next, [...path, name]);
      if (found) return found;
    }
    done.add(name);
    return null;
  };
  for (const name of graph.keys()) {
    const found = follow(name, []);
    if (found) return found;
  }
  return null;
}

test("no circle of files", () => {
  const graph = files();
  assert.ok(graph.size > 60);
  assert.equal(circle(graph), null);
});

test("no circle of rooms, and every file stands in one", () => {
  const graph = rooms(files());
  assert.ok(graph.size > 8);
  const outside = [...graph.keys()].filter((name) => name.includes("."));
  assert.deepEqual(outside, ["vite-env.d.ts"]);
  assert.equal(circle(graph), null);
});

for (const line of [
  'import { a } from "../queue/a.ts";',
  'export * from "../queue/a.ts";',
  'import "../queue/a.ts";',
  'void import("../queue/a.ts");',
])
  test(`a circle would be found: ${line}`, () => {
    const graph: Graph = new Map([
      ["kit/b.ts", new Set(imported("kit/b.ts", line))],
      ["queue/a.ts", new Set(["queue/c.ts"])],
      ["queue/c.ts", new Set(["kit/d.ts"])],
    ]);
    assert.deepEqual(circle(rooms(graph)), ["kit", "queue", "kit"]);
    assert.equal(circle(graph), null, "no circle of files");
    graph.set("kit/d.ts", new Set(["kit/b.ts"]));
    assert.deepEqual(circle(graph), ["kit/b.ts", "queue/a.ts", "queue/c.ts", "kit/d.ts", "kit/b.ts"]);
  });
