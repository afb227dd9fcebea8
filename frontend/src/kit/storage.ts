/** The browser's storage, if it allows any. */

/** Run `act` with the browser's storage. Returns its result; undefined if the browser allows no storage, or `act` fails. */
export function withStorage<T>(act: (storage: Storage) => T): T | undefined {
  try {
    return act(localStorage);
  } catch {
    return undefined;
  }
}

export const storage = {
  get: (key: string): string | null => withStorage((all) => all.getItem(`farhand-${key}`)) ?? null,
  set: (key: string, value: string): void => withStorage((all) => all.setItem(`farhand-${key}`, value)),
};
