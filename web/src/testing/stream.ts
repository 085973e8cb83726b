/** What the browser offers, with the server's side in our hand; jsdom has none. */
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

  tell(kind: string, id: string) {
    this.dispatchEvent(new MessageEvent(kind, { data: `{"id":"${id}","kind":"${kind}"}`, lastEventId: id }));
  }
}
