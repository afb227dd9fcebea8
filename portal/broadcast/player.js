// Plays the movie of the day from its beginning. Segments are appended in order as the playlist names them; where a
// browser has no Media Source Extensions, it plays the playlist itself (HLS).
const AHEAD_S = 30; // seconds that are loaded before they are shown
const KEPT_S = 60; // seconds that are kept after they were shown
const LOOK_MS = 1000;
const SOON = 15; // looks, after which no movie is about to come
const video = document.querySelector("video");
const status = document.querySelector("[role=status]");
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const once = (what, name) => new Promise((done) => what.addEventListener(name, done, { once: true }));

async function text(url) {
  for (let looks = 1; ; looks++) {
    const answer = await fetch(url).catch(() => null);
    if (answer?.ok) return answer.text();
    if (answer?.status === 404) throw new Error("This movie is no longer shown. Load the page again.");
    const said = looks < SOON ? "The movie is not here yet; it begins within a few seconds." : "No movie is broadcast now. When there is one, it begins here by itself.";
    if (status.textContent !== said) status.textContent = said;
    await pause(LOOK_MS);
  }
}

async function bytes(url) {
  for (let tries = 0; tries < 5; tries++) {
    const answer = await fetch(url).catch(() => null);
    if (answer?.ok) return answer.arrayBuffer();
    await pause(LOOK_MS);
  }
  throw new Error("A part of the movie cannot be loaded. Load the page again.");
}

async function append(buffer, data) {
  buffer.appendBuffer(data);
  await once(buffer, "updateend");
  const shown = video.currentTime - KEPT_S;
  if (shown > 0 && buffer.buffered.length && buffer.buffered.start(0) < shown) {
    buffer.remove(0, shown);
    await once(buffer, "updateend");
  }
}

async function play(Source) {
  const lines = (await text("index.m3u8")).trim().split("\n");
  const codec = /CODECS="([\w.]+)"/.exec(lines.join("\n"))[1];
  document.querySelector("#title").textContent = /VALUE="(.*)"/.exec(lines.join("\n"))?.[1] ?? "";
  const playlist = new URL(lines.at(-1), location.href);
  const source = new Source();
  video.disableRemotePlayback = true;
  video.src = URL.createObjectURL(source);
  await once(source, "sourceopen");
  const buffer = source.addSourceBuffer(`video/mp4; codecs="${codec}"`);
  await append(buffer, await bytes(new URL("init.mp4", playlist)));
  status.textContent = "";
  for (let next = 0, ended = false; !ended; ) {
    const told = (await text(playlist)).trim().split("\n");
    const names = told.filter((line) => line && !line.startsWith("#"));
    for (; next < names.length; next++) {
      while (video.buffered.length && video.buffered.end(0) - video.currentTime > AHEAD_S) await pause(LOOK_MS);
      await append(buffer, await bytes(new URL(names[next], playlist)));
      if (next === 0) {
        video.currentTime = video.buffered.start(0);
        video.play().catch(() => {}); // the person presses play where the browser wants that
      }
    }
    ended = told.includes("#EXT-X-ENDLIST");
    if (!ended) await pause(LOOK_MS);
  }
  source.endOfStream();
}

// `?loop`, for a screen that nobody touches: from the beginning again, then with the movie that is shown by then
const again = () => location.search === "?loop" && setTimeout(() => location.reload(), 5 * LOOK_MS);
video.addEventListener("ended", again);
const Source = window.ManagedMediaSource ?? window.MediaSource;
if (Source) play(Source).catch((error) => ((status.textContent = error.message), again()));
else video.src = "index.m3u8";
