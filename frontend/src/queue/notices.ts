/** How this browser tells a person who looks elsewhere: by notifications of an open page, or also without one (Web Push). */
import { storage } from "../kit/storage.ts";
import { gettext } from "../kit/text.ts";
import { send } from "./choices.ts";

const WORKER = "/push-worker.js";
const ADDRESS = "/me/push/";
const CHOICE = "notify"; // of the browser's storage: "off" once a person has switched notifications off

const SUBSCRIBE_MS = 20_000; // without a connection some browsers wait for their push service for ever

export interface Notice {
  title: string;
  body: string;
  tag: string;
  icon: string;
  url: string;
}

export class Notices {
  private registration: ServiceWorkerRegistration | null = null;
  private subscription: PushSubscription | null = null;
  private failed = false; // the browser refused to subscribe on this page; until then a press tries it
  private busy = false;
  private key: string;
  private token: string;

  /** `key`: the installation's public key, empty if it tells no browser; `told`: the portal tells this one already. */
  constructor(key: string, token: string, told: boolean, changed: () => void) {
    this.key = key;
    this.token = token;
    if (told && this.possible) void this.find().then(changed, () => undefined);
  }

  /** Whether there is anything to choose here. */
  get offered(): boolean {
    return "Notification" in window && Notification.permission !== "denied";
  }

  /** Whether this browser tells as well as it can. */
  get on(): boolean {
    return this.pages && (this.subscription !== null || !this.possible);
  }

  /** Whether an open page tells. */
  private get pages(): boolean {
    return "Notification" in window && Notification.permission === "granted" && storage.get(CHOICE) !== "off";
  }

  /** Whether this browser might tell without an open page. */
  private get possible(): boolean {
    return this.key !== "" && !this.failed && "serviceWorker" in navigator && "PushManager" in window;
  }

  /** Switch it on or off; only ever called for a press. Resolves to a sentence that says what is now. */
  async press(): Promise<string> {
    if (this.busy) return "";
    this.busy = true;
    try {
      return await (this.on ? this.stop() : this.begin());
    } finally {
      this.busy = false;
    }
  }

  /** Show a notification of this page, if the person wants any. */
  show({ title, url, ...options }: Notice, clicked: () => void): void {
    if (!this.pages) return;
    const more = { ...options, requireInteraction: true };
    if (this.subscription && this.registration) {
      // the worker's own replaces it; its click opens the address
      void this.registration.showNotification(title, { ...more, data: { url } });
      return;
    }
    try {
      const note = new Notification(title, more);
      note.onclick = () => {
        window.focus();
        note.close();
        clicked();
      };
    } catch {
      // on phones only service workers may show notifications
    }
  }

  private async find(): Promise<void> {
    this.registration = (await navigator.serviceWorker.getRegistration("/")) ?? null;
    this.subscription = (await this.registration?.pushManager.getSubscription()) ?? null;
  }

  private async begin(): Promise<string> {
    if ((await Notification.requestPermission()) !== "granted")
      return gettext("This browser may not notify you. Keep this page open: its title and a sound tell you.");
    storage.set(CHOICE, "on");
    if (!this.possible)
      return gettext("This browser will notify you while a page of the portal is open. It cannot do so when none is open.");
    let fresh: PushSubscription;
    try {
      fresh = await Promise.race([this.subscribe(), late(SUBSCRIBE_MS)]);
    } catch {
      this.failed = true;
      return gettext(
        "This browser will notify you while a page of the portal is open. For when none is open, its push service could not be reached.",
      );
    }
    const { ok, text } = await send(ADDRESS, this.token, { do: "tell", endpoint: fresh.endpoint, ...fresh.toJSON().keys });
    if (!ok) return text;
    this.subscription = fresh;
    return gettext("This browser will notify you, also when no page of the portal is open.");
  }

  private async subscribe(): Promise<PushSubscription> {
    this.registration = await navigator.serviceWorker.register(WORKER, { updateViaCache: "none" });
    const pushes = this.registration.pushManager;
    const options = { userVisibleOnly: true, applicationServerKey: this.key };
    try {
      return await pushes.subscribe(options);
    } catch (error) {
      const old = await pushes.getSubscription(); // with the key of another installation, or of an earlier one
      if (!old) throw error;
      await old.unsubscribe();
      return pushes.subscribe(options);
    }
  }

  private async stop(): Promise<string> {
    storage.set(CHOICE, "off");
    const old = this.subscription;
    this.subscription = null;
    if (old) {
      const { ok, text } = await send(ADDRESS, this.token, { do: "stop", endpoint: old.endpoint });
      const ended = await old.unsubscribe().catch(() => false);
      if (!ok && !ended) {
        this.subscription = old;
        storage.set(CHOICE, "on");
        return text;
      }
    }
    return gettext("This browser notifies you no more.");
  }
}

/** Return a promise that is rejected after so long. */
function late(ms: number): Promise<never> {
  return new Promise((_, reject) => setTimeout(() => reject(new Error("late")), ms));
}
