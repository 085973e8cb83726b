/** Prints one part of the page alone: what is around it is no part of a report. */

import "./printing.css";

const PRINTED = "print-only";

export function printElement(id: string, title: string): void {
  const element = document.getElementById(id);
  if (element === null) return;
  const copy = document.createElement("div");
  copy.className = PRINTED;
  const heading = document.createElement("h1");
  heading.textContent = title;
  const content = element.cloneNode(true) as HTMLElement;
  content.removeAttribute("id");
  copy.append(heading, content);
  document.body.append(copy);
  const end = () => copy.remove();
  window.addEventListener("afterprint", end, { once: true });
  window.print();
}
