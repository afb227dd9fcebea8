/** Loads large modules before they are used, so that they are there when the connection is lost. */

const LOOK_MS = 2000; // between two checks whether the page is idle
let last: Promise<unknown> = Promise.resolve();

/** Call `load` while the page is idle, after all earlier ones. If it fails, the module is loaded when it is used. */
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
