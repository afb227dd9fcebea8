/** The browser's storage, if it allows any. */
export const storage = {
  get(key: string): string | null {
    try {
      return localStorage.getItem(`farhand-${key}`);
    } catch {
      return null;
    }
  },
  set(key: string, value: string): void {
    try {
      localStorage.setItem(`farhand-${key}`, value);
    } catch {
      // the value is lost with this page
    }
  },
};
