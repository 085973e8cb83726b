/** A ref that scrolls what has just appeared to where it is seen. */
export function intoView(element: HTMLElement | null): void {
  element?.scrollIntoView?.({ block: "nearest" });
}
