/** What a page listens to: a stream that all pages of the browser share, or one of its own where that cannot be. */

import type { Told, Wish } from "./sharing";

/** As much of an `EventSource` as is needed here. */
export interface Source {
  onopen: (() => void) | null;
  onerror: (() => void) | null;
  addEventListener: (kind: string, take: (message: MessageEvent<string>) => void) => void;
  /** @param anew - Ends the stream for all pages that share it, since it may hang; they open it again. */
  close: (anew?: boolean) => void;
}

/** Begins to listen to an address. */
export function openSource(address: string): Source {
  if (typeof SharedWorker !== "undefined") return new SharedSource(address);
  return new EventSource(address) as Source; // whose listeners may look at more than ours do
}

class SharedSource implements Source {
  static #port: MessagePort | undefined;
  static readonly #open = new Map<string, SharedSource>();
  onopen: (() => void) | null = null;
  onerror: (() => void) | null = null;
  readonly #messages = new EventTarget();

  constructor(readonly address: string) {
    SharedSource.#open.set(address, this);
    SharedSource.#wish({ listen: address });
  }

  close(anew = false): void {
    if (SharedSource.#open.get(this.address) !== this) return;
    SharedSource.#open.delete(this.address);
    SharedSource.#wish({ leave: this.address, anew });
  }

  addEventListener(kind: string, take: (message: MessageEvent<string>) => void): void {
    this.#messages.addEventListener(kind, take as (event: Event) => void);
  }

  static #wish(wish: Wish): void {
    SharedSource.#port ??= SharedSource.#connected();
    SharedSource.#port.postMessage(wish);
  }

  static #connected(): MessagePort {
    const worker = new SharedWorker(new URL("./shared.worker.ts", import.meta.url), { type: "module" });
    worker.port.onmessage = ({ data }: MessageEvent<Told>) => SharedSource.#hand(data);
    // A page that goes for good says so; of one that only rests, its follower closes the connection.
    addEventListener("pagehide", () => {
      for (const source of SharedSource.#open.values()) source.close();
    });
    return worker.port;
  }

  static #hand(told: Told): void {
    const source = SharedSource.#open.get(told.address);
    if (source !== undefined) source.#hear(told);
  }

  #hear(told: Told): void {
    if (told.what === "message") {
      this.#messages.dispatchEvent(new MessageEvent(told.kind, { data: told.data, lastEventId: told.id }));
    } else if (told.what === "open") this.onopen?.();
    else this.onerror?.();
  }
}
