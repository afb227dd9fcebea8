/** Requests to the portal; each has a limit, after which it fails as one without a connection does. */
const LONGEST_MS = 10_000;
/** For a file, which may come over a slow line (ms). */
export const FILE_MS = 120_000;

/** As `fetch`, for at most `longestMs` until the whole answer has come. Rejects as `fetch` does, or with a TimeoutError. */
export function request(address: string, options: RequestInit = {}, longestMs = LONGEST_MS): Promise<Response> {
  return fetch(address, { ...options, signal: AbortSignal.timeout(longestMs) });
}
