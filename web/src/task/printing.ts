/** Prints one part of the page without the rest. */

import { useEffect } from "react";
import "./printing.css";

const PRINTED = "print-only";
const SCHEME = "data-mantine-color-scheme";

/** While the component is mounted, only its element is printed, below a title. */
export function usePrintedAlone(id: string, title: string): void {
  useEffect(() => {
    let restore: (() => void) | undefined;
    const end = () => {
      restore?.();
      restore = undefined;
    };
    const begin = () => {
      end();
      restore = putAlone(id, title);
    };
    window.addEventListener("beforeprint", begin);
    window.addEventListener("afterprint", end);
    return () => {
      window.removeEventListener("beforeprint", begin);
      window.removeEventListener("afterprint", end);
      end();
    };
  }, [id, title]);
}

/** Adds a printable copy in light colours; returns the function that removes it. */
function putAlone(id: string, title: string): (() => void) | undefined {
  const element = document.getElementById(id);
  if (element === null) return undefined;
  const copy = copyOf(element, title);
  const root = document.documentElement;
  const scheme = root.getAttribute(SCHEME);
  document.body.append(copy);
  root.setAttribute(SCHEME, "light");
  return () => {
    copy.remove();
    if (scheme !== null) root.setAttribute(SCHEME, scheme);
  };
}

function copyOf(element: HTMLElement, title: string): HTMLElement {
  const copy = document.createElement("div");
  copy.className = PRINTED;
  const heading = document.createElement("h1");
  heading.textContent = title;
  const content = element.cloneNode(true) as HTMLElement;
  content.removeAttribute("id");
  copy.append(heading, content);
  return copy;
}
