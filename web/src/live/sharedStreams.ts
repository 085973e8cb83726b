/** Event streams shared by all pages of a browser: it allows six connections to a server, and each page needs two. */

import { EVENT_KINDS } from "./events";

/** A page's request. `restart` closes the stream for all pages, which then open it again. */
export type StreamRequest = { subscribe: string } | { unsubscribe: string; restart: boolean };

/** A message from a stream to a page, with the address that the page subscribed to. */
export type StreamMessage =
  | { address: string; type: "open" | "error" }
  | { address: string; type: "message"; kind: string; data: string; id: string };

/** The message port of a page. */
export interface Page {
  postMessage: (message: StreamMessage) => void;
}

const KINDS = [...EVENT_KINDS, "reset", "state"];

interface SharedStream {
  source: EventSource;
  /** The address of each subscribed page; its `after` parameter is the last event that the page has seen. */
  pages: Map<Page, string>;
  open: boolean;
  /** Id of the last event received. */
  last: string;
}

/** Keeps one stream for each endpoint, regardless of the number of pages; messages carry each page's own address. */
export class SharedStreams {
  readonly #streams = new Map<string, SharedStream>();

  handle(page: Page, request: StreamRequest): void {
    if ("subscribe" in request) this.#subscribe(page, request.subscribe);
    else this.#unsubscribe(page, request.unsubscribe, request.restart);
  }

  #subscribe(page: Page, address: string): void {
    const stream = this.#streams.get(endpointOf(address));
    if (stream === undefined) {
      this.#open(page, address);
      return;
    }
    stream.pages.set(page, address);
    if (stream.open) this.#sendOpen(page, address, stream.last);
  }

  #open(page: Page, address: string): void {
    const endpoint = endpointOf(address);
    const source = new EventSource(address);
    const stream: SharedStream = { source, pages: new Map([[page, address]]), open: false, last: afterOf(address) };
    this.#streams.set(endpoint, stream);
    source.onopen = () => {
      stream.open = true;
      for (const [subscriber, requested] of stream.pages) this.#sendOpen(subscriber, requested, stream.last);
    };
    source.onerror = () => this.#close(endpoint);
    for (const kind of KINDS) {
      source.addEventListener(kind, ({ data, lastEventId: id }) => {
        if (id) stream.last = id;
        for (const [subscriber, requested] of stream.pages)
          subscriber.postMessage({ address: requested, type: "message", kind, data, id });
      });
    }
  }

  /** Reports the open stream to a page, followed by a reset if the page has missed events. */
  #sendOpen(page: Page, address: string, last: string): void {
    page.postMessage({ address, type: "open" });
    const after = afterOf(address);
    if (after && after !== last) page.postMessage({ address, type: "message", kind: "reset", data: "", id: last });
  }

  #unsubscribe(page: Page, address: string, restart: boolean): void {
    const endpoint = endpointOf(address);
    const stream = this.#streams.get(endpoint);
    if (stream === undefined || !stream.pages.delete(page)) return;
    if (restart || stream.pages.size === 0) this.#close(endpoint);
  }

  #close(endpoint: string): void {
    const stream = this.#streams.get(endpoint);
    this.#streams.delete(endpoint);
    stream?.source.close();
    for (const [page, address] of stream?.pages ?? []) page.postMessage({ address, type: "error" });
  }
}

/** Returns the address without its `after` parameter. */
function endpointOf(address: string): string {
  const url = new URL(address);
  url.searchParams.delete("after");
  return url.href;
}

function afterOf(address: string): string {
  return new URL(address).searchParams.get("after") ?? "";
}
