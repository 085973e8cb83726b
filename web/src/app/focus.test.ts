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

/** What a button does that works for a while. */
async function pressAndDisable(id: string): Promise<void> {
  button("one").focus();
  button(id).focus();
  press();
  button(id).blur(); // as browsers do with what is disabled
  button(id).disabled = true;
  await told();
}

/** The keeper looks after the present task. */
const told = () => new Promise((resume) => setTimeout(resume, 10));

test("where what had the focus is gone, it goes back to what had it before", async () => {
  button("one").focus();
  button("two").focus();
  press();
  document.querySelector("div")?.remove();
  await told();
  expect(document.activeElement).toBe(button("one"));
});

test("it goes past all that are gone", async () => {
  for (const id of ["one", "three", "two"]) button(id).focus();
  press();
  button("three").remove();
  button("two").remove();
  await told();
  expect(document.activeElement).toBe(button("one"));
});

test("what took the focus itself keeps it", async () => {
  button("one").focus();
  button("two").focus();
  press();
  document.querySelector("div")?.remove();
  button("three").focus();
  await told();
  expect(document.activeElement).toBe(button("three"));
});

test("what was disabled for a while has the focus again afterwards", async () => {
  await pressAndDisable("two");
  expect(document.activeElement).toBe(document.body);
  button("two").disabled = false;
  await told();
  expect(document.activeElement).toBe(button("two"));
});

test("for who points nothing is done", async () => {
  button("one").focus();
  button("two").focus();
  document.dispatchEvent(new Event("pointerdown"));
  document.querySelector("div")?.remove();
  await told();
  expect(document.activeElement).toBe(document.body);
});

test("on its way from one to the next the focus is not taken back, whatever changes meanwhile", async () => {
  button("one").focus();
  press();
  button("one").addEventListener("blur", () => void button("one").setAttribute("disabled", ""));
  button("one").blur(); // nothing has it now
  await Promise.resolve(); // an observer would have been told by now
  button("one").removeAttribute("disabled");
  button("three").focus();
  await told();
  expect(document.activeElement).toBe(button("three"));
});

test("who goes on while it is disabled is not called back to it", async () => {
  await pressAndDisable("two");
  press(" ");
  button("two").disabled = false;
  await told();
  expect(document.activeElement).toBe(document.body);
});

test("a modifier alone is no work by keyboard", async () => {
  button("two").focus();
  document.dispatchEvent(new Event("pointerdown"));
  button("two").focus();
  button("two").blur();
  press("Control");
  button("three").remove();
  await told();
  expect(document.activeElement).toBe(document.body);
});

test("while a dialog is open nothing behind it gets the focus", async () => {
  document.body.insertAdjacentHTML("beforeend", "<div aria-modal=true><button id=four></button></div>");
  button("one").focus();
  button("four").focus();
  press();
  button("four").remove();
  await told();
  expect(document.activeElement).toBe(document.body);
  document.querySelector("[aria-modal]")?.remove();
  await told();
  expect(document.activeElement).toBe(button("one"));
});
