import { afterEach, beforeEach, expect, test } from "vitest";
import { keepFocus } from "./focus";

let end: () => void;

beforeEach(() => {
  document.body.innerHTML = "<button id=one></button><div><button id=two></button></div><button id=three></button>";
  end = keepFocus();
});
afterEach(() => end());

function button(id: string): HTMLButtonElement {
  return document.getElementById(id) as HTMLButtonElement;
}

function press(key = "Enter"): void {
  window.dispatchEvent(new KeyboardEvent("keydown", { key }));
}

/** A button that is disabled while its work runs. */
async function pressAndDisable(id: string): Promise<void> {
  button("one").focus();
  button(id).focus();
  press();
  button(id).blur(); // as browsers do for disabled elements
  button(id).disabled = true;
  await settled();
}

/** Lets mutation observers run. */
const settled = () => new Promise((resume) => setTimeout(resume, 10));

test("when the focused element disappears, the focus returns to the previous one", async () => {
  button("one").focus();
  button("two").focus();
  press();
  document.querySelector("div")?.remove();
  await settled();
  expect(document.activeElement).toBe(button("one"));
});

test("elements that have disappeared are skipped", async () => {
  for (const id of ["one", "three", "two"]) button(id).focus();
  press();
  button("three").remove();
  button("two").remove();
  await settled();
  expect(document.activeElement).toBe(button("one"));
});

test("an element that takes the focus itself keeps it", async () => {
  button("one").focus();
  button("two").focus();
  press();
  document.querySelector("div")?.remove();
  button("three").focus();
  await settled();
  expect(document.activeElement).toBe(button("three"));
});

test("an element that was disabled for a while gets the focus back", async () => {
  await pressAndDisable("two");
  expect(document.activeElement).toBe(document.body);
  button("two").disabled = false;
  await settled();
  expect(document.activeElement).toBe(button("two"));
});

test("the focus is not restored for users of a pointer", async () => {
  button("one").focus();
  button("two").focus();
  document.dispatchEvent(new Event("pointerdown"));
  document.querySelector("div")?.remove();
  await settled();
  expect(document.activeElement).toBe(document.body);
});

test("the focus is not taken back while it moves from one element to another", async () => {
  button("one").focus();
  press();
  button("one").addEventListener("blur", () => void button("one").setAttribute("disabled", ""));
  button("one").blur(); // nothing has the focus now
  await Promise.resolve(); // an observer would have run by now
  button("one").removeAttribute("disabled");
  button("three").focus();
  await settled();
  expect(document.activeElement).toBe(button("three"));
});

test("the focus does not return to a disabled element after the user has moved on", async () => {
  await pressAndDisable("two");
  press(" ");
  button("two").disabled = false;
  await settled();
  expect(document.activeElement).toBe(document.body);
});

test("a modifier alone does not count as keyboard use", async () => {
  button("two").focus();
  document.dispatchEvent(new Event("pointerdown"));
  button("two").focus();
  button("two").blur();
  press("Control");
  button("three").remove();
  await settled();
  expect(document.activeElement).toBe(document.body);
});

test("while a dialog is open nothing behind it gets the focus", async () => {
  document.body.insertAdjacentHTML("beforeend", "<div aria-modal=true><button id=four></button></div>");
  button("one").focus();
  button("four").focus();
  press();
  button("four").remove();
  await settled();
  expect(document.activeElement).toBe(document.body);
  document.querySelector("[aria-modal]")?.remove();
  await settled();
  expect(document.activeElement).toBe(button("one"));
});
