/**
 * The service worker: it shows what the portal tells over Web Push, and nothing else. It keeps no page and answers no
 * request of one. It imports nothing, because browsers load it as one file.
 */

interface Told {
  title: string;
  /** `{time}` stands for the end of the offer. */
  body: string;
  url: string;
  lang: string;
  tag: string;
  icon: string;
  until_ms: number;
}
interface Lasting extends Event {
  waitUntil(work: Promise<unknown>): void;
}
interface PushEvent extends Lasting {
  data: { json(): unknown } | null;
}
interface ClickEvent extends Lasting {
  notification: Notification;
}
interface ChangeEvent extends Lasting {
  newSubscription?: PushSubscription | null;
}
interface WindowClient {
  url: string;
  focus(): Promise<unknown>;
}
/** As much of `ServiceWorkerGlobalScope` as is used: TypeScript has its types only without those of pages. */
interface Scope {
  registration: ServiceWorkerRegistration;
  clients: {
    matchAll(options: { type: "window"; includeUncontrolled: boolean }): Promise<WindowClient[]>;
    openWindow(url: string): Promise<unknown>;
  };
  skipWaiting(): Promise<void>;
  addEventListener(type: "install", listener: (event: Lasting) => void): void;
  addEventListener(type: "push", listener: (event: PushEvent) => void): void;
  addEventListener(type: "notificationclick", listener: (event: ClickEvent) => void): void;
  addEventListener(type: "pushsubscriptionchange", listener: (event: ChangeEvent) => void): void;
}

const scope = self as unknown as Scope;
const ADDRESS = "/me/push/";
const LONGEST_MS = 10_000;

scope.addEventListener("install", (event) => event.waitUntil(scope.skipWaiting()));
scope.addEventListener("push", (event) => {
  if (event.data) event.waitUntil(show(event.data.json() as Told));
});
scope.addEventListener("notificationclick", (event) => {
  event.notification.close();
  event.waitUntil(open((event.notification.data as { url: string }).url));
});
scope.addEventListener("pushsubscriptionchange", (event) => event.waitUntil(renew(event.newSubscription ?? null)));

async function show({ title, body, url, lang, tag, icon, until_ms }: Told): Promise<void> {
  const time = new Date(until_ms).toLocaleTimeString(lang);
  await scope.registration.showNotification(title, {
    body: body.replace("{time}", time),
    data: { url },
    icon,
    lang,
    requireInteraction: true,
    tag,
  });
}

/** Lead to the page, in the window that shows it already or in a new one. */
async function open(url: string): Promise<void> {
  const windows = await scope.clients.matchAll({ type: "window", includeUncontrolled: true });
  const there = windows.find((one) => new URL(one.url).pathname === url);
  await (there ? there.focus() : scope.clients.openWindow(url));
}

/** Tell the portal the browser's new address at its push service, if the person is still signed in and told here. */
async function renew(given: PushSubscription | null): Promise<void> {
  const answer = await ask({});
  if (!answer.ok) return;
  const { key, token, told } = (await answer.json()) as { key: string; token: string; told: boolean };
  if (!told || !key) return;
  const fresh = given ?? (await scope.registration.pushManager.subscribe({ userVisibleOnly: true, applicationServerKey: key }));
  const body = new URLSearchParams({ do: "renew", csrfmiddlewaretoken: token, endpoint: fresh.endpoint, ...fresh.toJSON().keys });
  await ask({ method: "POST", body });
}

function ask(options: RequestInit): Promise<Response> {
  const signal = AbortSignal.timeout(LONGEST_MS);
  return fetch(ADDRESS, { ...options, headers: { Accept: "application/json" }, redirect: "manual", signal });
}
