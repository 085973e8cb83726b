import { MantineProvider } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import "../i18n";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { SequenceSteps } from "./SequenceSteps";
import type { Edit, Sequence } from "./sequences";

type Then = { onSettled: (there: unknown, refusal: Error | null) => void };

function sequence(version: number, places: string[]): Sequence {
  const steps = places.map((Location) => {
    return { skill: "drive", arguments: { Location }, agent: "base_1", works: true, problems: [] };
  });
  return { id: "round", title: "", version, count: steps.length, works: true, steps };
}

function page(there: Sequence, settle: (then: Then) => void) {
  const edit = (_: Edit, then?: unknown) => settle(then as Then);
  const forms = { forms: [], open: () => {}, close: () => {}, follow: () => {} };
  return (
    <MantineProvider>
      <QueryClientProvider client={queryClient}>
        <SequenceSteps sequence={there} skills={new Map()} pending={false} edit={edit} forms={forms} />
      </QueryClientProvider>
    </MantineProvider>
  );
}

/** Presses "down" of the first step, renders the next version, and returns the focused element. */
async function focusAfterMove(refusal: Error | null): Promise<Element | null> {
  const settle = ({ onSettled }: Then) => onSettled(null, refusal);
  const { rerender } = render(page(sequence(1, ["pallet_a", "kit_1", "kit_2"]), settle));
  const [first] = screen.getAllByRole("button", { name: /: down$/ });
  if (first !== undefined) await userEvent.click(first);
  (document.activeElement as HTMLElement).blur();
  rerender(page(sequence(2, ["kit_1", "pallet_a", "kit_2"]), settle));
  return document.activeElement;
}

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
  vi.stubGlobal(
    "ResizeObserver",
    class {
      observe() {}
      unobserve() {}
      disconnect() {}
    },
  );
  queryClient.setQueryData(keys.me, { operations: ["put_document"] });
});

test("after a step was removed, the focus is on the next one, but not on its bin", async () => {
  const settle = ({ onSettled }: Then) => onSettled(null, null);
  const { rerender } = render(page(sequence(1, ["pallet_a", "kit_1", "kit_2"]), settle));
  const [, second] = screen.getAllByRole("button", { name: /^Remove|: remove|remove/i });
  if (second !== undefined) await userEvent.click(second);
  rerender(page(sequence(2, ["pallet_a", "kit_2"]), settle));
  expect(document.activeElement).toHaveAttribute("data-mover", "drag 1");
});

test("the focus follows a moved step", async () => {
  expect(await focusAfterMove(null)).toHaveAttribute("data-mover", "down 1");
});

test("after a refused move, later changes by others do not move the focus", async () => {
  expect(await focusAfterMove(new Error("refused"))).toBe(document.body);
});
