/** Keeps the focus for keyboard users: when the focused element disappears, the focus returns to the previous one. */

const MOST = 20; // elements in the history; all of them disappear only when another tab is opened
const MODIFIERS = new Set(["Shift", "Control", "Alt", "Meta", "AltGraph"]);

/** Starts restoring the focus; returns the function that stops it. */
export function keepFocus(): () => void {
  const keeper = new Keeper();
  const end = new AbortController();
  const options = { capture: true, signal: end.signal };
  document.addEventListener("focusin", ({ target }) => keeper.remember(target), options);
  // On the window, before all other listeners: an element closed by a key is gone when the next listener is called.
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
    // A key pressed while nothing is focused ends this: later keys must not go to an element that reappears.
    if (nothingHasIt()) this.had = [];
  }

  /** Users of a pointer need no focus; and some fields open their lists when focused. */
  leave(): void {
    this.byKeyboard = false;
    this.had = [];
    clearTimeout(this.timer);
    this.timer = undefined;
  }

  /** While the focus moves between elements, nothing is focused; restoring it then would undo the move. */
  look(): void {
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      this.restore();
    });
  }

  private restore(): void {
    if (!this.byKeyboard || !nothingHasIt()) return;
    this.had = this.had.filter((one) => one.isConnected);
    const dialog = document.querySelector("[aria-modal=true]"); // makes the rest of the page inert
    const last = this.had.findLast((one) => dialog === null || dialog.contains(one));
    // An element that is disabled during its work gets the focus back when it is enabled again.
    if (last !== undefined && !last.matches(":disabled")) last.focus({ preventScroll: true });
  }
}

function nothingHasIt(): boolean {
  return document.activeElement === null || document.activeElement === document.body;
}
