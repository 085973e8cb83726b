/** Keeps the focus of who works by keyboard: where what had it is gone, it goes back to what had it before. */

const MOST = 20; // things that had it; it is lost with all of them on a jump to another tab only
const MODIFIERS = new Set(["Shift", "Control", "Alt", "Meta", "AltGraph"]);

/** Keeps the focus from now on; returns how to end that. */
export function keepFocus(): () => void {
  const keeper = new Keeper();
  const end = new AbortController();
  const options = { capture: true, signal: end.signal };
  document.addEventListener("focusin", ({ target }) => keeper.remember(target), options);
  // At the window, and before all others there: what a key closes is gone as soon as the next listener is called.
  window.addEventListener("keydown", (event) => keeper.hear(event), options);
  document.addEventListener("pointerdown", () => keeper.leave(), options);
  const observer = new MutationObserver(() => keeper.look());
  observer.observe(document.body, { childList: true, subtree: true, attributes: true, attributeFilter: ["disabled"] });
  return () => {
    observer.disconnect();
    keeper.leave();
    end.abort();
  };
}

class Keeper {
  private byKeyboard = false;
  private had: HTMLElement[] = [];
  private timer: ReturnType<typeof setTimeout> | undefined;

  remember(target: EventTarget | null): void {
    if (!(target instanceof HTMLElement)) return;
    this.had = [...this.had.filter((one) => one.isConnected && one !== target), target].slice(-MOST);
  }

  hear({ key, repeat }: KeyboardEvent): void {
    if (MODIFIERS.has(key) || repeat) return;
    this.byKeyboard = true;
    // A key pressed while nothing has the focus ends this: later keys must not go to what comes back.
    if (nothingHasIt()) this.had = [];
  }

  /** For who points, nothing is lost; and some fields show their lists when they get the focus. */
  leave(): void {
    this.byKeyboard = false;
    this.had = [];
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  /** While the focus goes from one to the next, nothing has it: who looks then would take it back. */
  look(): void {
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      this.restore();
    });
  }

  private restore(): void {
    if (!this.byKeyboard || !nothingHasIt()) return;
    this.had = this.had.filter((one) => one.isConnected);
    const dialog = document.querySelector("[aria-modal=true]"); // while one is open, nothing behind it is reached
    const last = this.had.findLast((one) => dialog === null || dialog.contains(one));
    // What is disabled for a moment, while its work is done, gets the focus back when it is not any more.
    if (last !== undefined && !last.matches(":disabled")) last.focus({ preventScroll: true });
  }
}

function nothingHasIt(): boolean {
  return document.activeElement === null || document.activeElement === document.body;
}
