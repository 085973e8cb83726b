/** Streams that several pages of one browser share: it has six connections to a server, and each page wants two. */

import { EVENT_KINDS } from "./events";

/** A page's request: listens to an address, or no longer; `anew` ends the stream for all pages, which open it again. */
export type Wish = { listen: string } | { leave: string; anew: boolean };

/** What a page receives of an address. */
export type Told =
  | { address: string; what: "open" | "error" }
  | { address: string; what: "message"; kind: string; data: string; id: string };

/** The one that a page is reached by. */
export interface Listener {
  postMessage: (told: Told) => void;
}

const KINDS = [...EVENT_KINDS, "reset", "state"];

interface Shared {
  source: EventSource;
  /** Pages, by the address each has asked for: it may say behind which event it wants to go on. */
  listeners: Map<Listener, string>;
  open: boolean;
  /** Id of the last event that came. */
  last: string;
}

/** Keeps one stream for each place, however many pages listen; each gets the address that it asked for. */
export class Sharing {
  readonly #streams = new Map<string, Shared>();

  /** Does what a page wants. */
  obey(page: Listener, wish: Wish): void {
    if ("listen" in wish) this.#listen(page, wish.listen);
    else this.#leave(page, wish.leave, wish.anew);
  }

  #listen(page: Listener, address: string): void {
    const known = this.#streams.get(placeOf(address));
    if (known === undefined) {
      this.#begin(page, address);
      return;
    }
    known.listeners.set(page, address);
    if (known.open) this.#welcome(page, address, known.last);
  }

  #begin(page: Listener, address: string): void {
    const place = placeOf(address);
    const source = new EventSource(address);
    const shared: Shared = { source, listeners: new Map([[page, address]]), open: false, last: afterOf(address) };
    this.#streams.set(place, shared);
    source.onopen = () => {
      shared.open = true;
      for (const [one, asked] of shared.listeners) this.#welcome(one, asked, shared.last);
    };
    source.onerror = () => this.#end(place);
    for (const kind of KINDS) {
      source.addEventListener(kind, ({ data, lastEventId: id }) => {
        if (id) shared.last = id;
        for (const [one, asked] of shared.listeners)
          one.postMessage({ address: asked, what: "message", kind, data, id });
      });
    }
  }

  /** Lets a page in; who wants to go on behind another event than the last one has missed some. */
  #welcome(page: Listener, address: string, last: string): void {
    page.postMessage({ address, what: "open" });
    const after = afterOf(address);
    if (after && after !== last) page.postMessage({ address, what: "message", kind: "reset", data: "", id: last });
  }

  #leave(page: Listener, address: string, anew: boolean): void {
    const place = placeOf(address);
    const shared = this.#streams.get(place);
    if (shared === undefined || !shared.listeners.delete(page)) return;
    if (anew || shared.listeners.size === 0) this.#end(place);
  }

  #end(place: string): void {
    const shared = this.#streams.get(place);
    this.#streams.delete(place);
    shared?.source.close();
    for (const [page, address] of shared?.listeners ?? []) page.postMessage({ address, what: "error" });
  }
}

/** Where a stream is, whatever it is to go on behind. */
function placeOf(address: string): string {
  const url = new URL(address);
  url.searchParams.delete("after");
  return url.href;
}

function afterOf(address: string): string {
  return new URL(address).searchParams.get("after") ?? "";
}
