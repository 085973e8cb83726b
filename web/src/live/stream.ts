/** A stream of server-sent events that reconnects after every interruption. */

import { openSource, type Source } from "./source";

const RETRY = 1000; // ms

export interface StreamOptions {
  /** The address; evaluated at each connection, since it may contain the id of the last event received. */
  address: () => string;
  /** A handler for each kind of message. */
  handlers: Record<string, (message: MessageEvent<string>) => void>;
  onOpen: () => void;
  /** Called once for each interruption. */
  onLost: () => void;
}

/** Closes the stream; `restart` if its connection may hang. */
export type Close = (restart?: boolean) => void;

/**
 * Follows a stream; returns the function that closes it.
 *
 * Browsers reconnect by themselves, but each gives up in different cases (a server or proxy that refuses the
 * connection); here all interruptions are handled alike.
 */
export function follow({ address, handlers, onOpen, onLost }: StreamOptions): Close {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let lost = false;
  let source = open();

  function open(): Source {
    const opened = openSource(address());
    opened.onopen = () => {
      lost = false;
      onOpen();
    };
    opened.onerror = () => {
      opened.close();
      timer = setTimeout(() => (source = open()), RETRY);
      if (!lost) onLost();
      lost = true;
    };
    for (const [kind, handler] of Object.entries(handlers)) opened.addEventListener(kind, handler);
    return opened;
  }

  return (restart) => {
    clearTimeout(timer);
    source.close(restart);
  };
}
