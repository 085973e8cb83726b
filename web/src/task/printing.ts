/** Prints one part of the page alone: what is around it is no part of a report. */

const PRINTED = "print-only";

export function printElement(id: string, title: string): void {
  const element = document.getElementById(id);
  if (element === null) return;
  const copy = document.createElement("div");
  copy.className = PRINTED;
  const heading = document.createElement("h1");
  heading.textContent = title;
  copy.append(heading, element.cloneNode(true));
  document.body.append(copy);
  const end = () => copy.remove();
  window.addEventListener("afterprint", end, { once: true });
  window.print();
}
