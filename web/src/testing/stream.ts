/** A fake `EventSource`, which jsdom lacks; tests send the server's messages with `send`. */
export class Stream extends EventTarget {
  static all: Stream[] = [];
  onopen: (() => void) | null = null;
  onerror: (() => void) | null = null;
  closed = false;

  constructor(readonly url: string) {
    super();
    Stream.all.push(this);
  }

  close() {
    this.closed = true;
  }

  send(kind: string, id: string) {
    this.dispatchEvent(new MessageEvent(kind, { data: `{"id":"${id}","kind":"${kind}"}`, lastEventId: id }));
  }
}
