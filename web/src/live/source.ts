/** The source of a stream: shared by all pages of the browser, or the page's own where shared workers are missing. */

import type { StreamMessage, StreamRequest } from "./sharedStreams";

/** The part of `EventSource` that is used here. */
export interface Source {
  onopen: (() => void) | null;
  onerror: (() => void) | null;
  addEventListener: (kind: string, listener: (message: MessageEvent<string>) => void) => void;
  /** @param restart - Closes the stream for all pages that share it, since it may hang; they open it again. */
  close: (restart?: boolean) => void;
}

export function openSource(address: string): Source {
  if (typeof SharedWorker !== "undefined") return new SharedSource(address);
  return new EventSource(address) as Source; // its listeners may take more arguments than ours
}

class SharedSource implements Source {
  static #port: MessagePort | undefined;
  static readonly #open = new Map<string, SharedSource>();
  onopen: (() => void) | null = null;
  onerror: (() => void) | null = null;
  readonly #messages = new EventTarget();

  constructor(readonly address: string) {
    SharedSource.#open.set(address, this);
    SharedSource.#send({ subscribe: address });
  }

  close(restart = false): void {
    if (SharedSource.#open.get(this.address) !== this) return;
    SharedSource.#open.delete(this.address);
    SharedSource.#send({ unsubscribe: this.address, restart });
  }

  addEventListener(kind: string, listener: (message: MessageEvent<string>) => void): void {
    this.#messages.addEventListener(kind, listener as (event: Event) => void);
  }

  static #send(request: StreamRequest): void {
    SharedSource.#port ??= SharedSource.#connect();
    SharedSource.#port.postMessage(request);
  }

  static #connect(): MessagePort {
    const worker = new SharedWorker(new URL("./shared.worker.ts", import.meta.url), { type: "module" });
    worker.port.onmessage = ({ data }: MessageEvent<StreamMessage>) => SharedSource.#dispatch(data);
    // A page that is closed unsubscribes here; a hidden page is disconnected in connection.ts.
    addEventListener("pagehide", () => {
      for (const source of SharedSource.#open.values()) source.close();
    });
    return worker.port;
  }

  static #dispatch(message: StreamMessage): void {
    const source = SharedSource.#open.get(message.address);
    if (source !== undefined) source.#receive(message);
  }

  #receive(message: StreamMessage): void {
    if (message.type === "message") {
      this.#messages.dispatchEvent(new MessageEvent(message.kind, { data: message.data, lastEventId: message.id }));
    } else if (message.type === "open") this.onopen?.();
    else this.onerror?.();
  }
}
