/** Loads what is large before it is used, so that it is there when the line is cut. */

const LOOK_MS = 2000; // between two looks whether the page is idle
let last: Promise<unknown> = Promise.resolve();

/** Load it while the page is idle, after everything that was asked for before. One that fails is loaded when it is used. */
export function prefetch(page: { readonly idle: boolean }, load: () => Promise<unknown>): void {
  last = last
    .then(() => atRest(page))
    .then(load)
    .catch(() => undefined);
}

async function atRest(page: { readonly idle: boolean }): Promise<void> {
  do await new Promise((done) => setTimeout(done, LOOK_MS));
  while (!page.idle);
}
