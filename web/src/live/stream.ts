/** A stream of server-sent events that opens itself again whenever it breaks. */

import { openSource, type Source } from "./source";

const AGAIN = 1000; // ms

export interface Followed {
  /** Where to listen; asked at each opening, since it may say what was heard last. */
  address: () => string;
  /** What to do with each kind of message. */
  messages: Record<string, (message: MessageEvent<string>) => void>;
  onOpen: () => void;
  /** Called once for each break. */
  onBreak: () => void;
}

/** Ends following; `anew` where the connection may hang. */
export type End = (anew?: boolean) => void;

/**
 * Follows a stream; returns how to end that.
 *
 * Browsers do open broken streams again, but each gives up in other cases (a server or proxy that refuses it): here
 * all breaks are healed in the same way.
 */
export function follow({ address, messages, onOpen, onBreak }: Followed): End {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let broken = false;
  let source = open();

  function open(): Source {
    const opened = openSource(address());
    opened.onopen = () => {
      broken = false;
      onOpen();
    };
    opened.onerror = () => {
      opened.close();
      timer = setTimeout(() => (source = open()), AGAIN);
      if (!broken) onBreak();
      broken = true;
    };
    for (const [kind, take] of Object.entries(messages)) opened.addEventListener(kind, take);
    return opened;
  }

  return (anew) => {
    clearTimeout(timer);
    source.close(anew);
  };
}
