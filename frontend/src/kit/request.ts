/** Requests and sockets to the portal; each has a limit, after which it fails as one without a connection does. */
const LONGEST_MS = 10_000;
/** For a file, which may come over a slow line (ms). */
export const FILE_MS = 120_000;
/** For a socket until it is open (ms). */
export const OPEN_MS = 10_000;

/** Return whether a request failed because its answer did not come in time: it may have been carried out. */
export function isLate(error: unknown): boolean {
  return error instanceof DOMException && error.name === "TimeoutError";
}

/** As `fetch`, for at most `longestMs` until the whole answer has come. Rejects as `fetch` does, or with a TimeoutError. */
export function request(address: string, options: RequestInit = {}, longestMs = LONGEST_MS): Promise<Response> {
  return fetch(address, { ...options, signal: AbortSignal.timeout(longestMs) });
}

/** Return a new socket at that path; it is closed if it does not open within `OPEN_MS`. */
export function openSocket(path: string, protocols: string[] = []): WebSocket {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  const socket = new WebSocket(`${scheme}://${location.host}${path}`, protocols);
  socket.binaryType = "arraybuffer";
  setTimeout(() => socket.readyState === WebSocket.CONNECTING && socket.close(), OPEN_MS);
  return socket;
}
