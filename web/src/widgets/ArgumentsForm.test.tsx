import { MantineProvider } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import "../i18n";
import { queryClient } from "../api/queries";
import { type Arguments, ArgumentsForm } from "./ArgumentsForm";
import dumped from "./arguments/parameters.testdata.json";
import type { Parameter } from "./arguments/schemas";

const MODULES = dumped as unknown as Record<string, Parameter[]>;

beforeEach(() => {
  const nothing = () => Promise.resolve(Response.json({ items: [], next: null, name: "sk:Thing", children: [] }));
  vi.stubGlobal("fetch", vi.fn(nothing));
  vi.stubGlobal(
    "ResizeObserver",
    class {
      observe() {}
      unobserve() {}
      disconnect() {}
    },
  );
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
});

function show(module: string, said: (value: Arguments) => void = () => {}) {
  function Page() {
    const [value, setValue] = useState<Arguments>({});
    const take = (next: Arguments) => {
      setValue(next);
      said(next);
    };
    return <ArgumentsForm parameters={MODULES[module] ?? []} value={value} onChange={take} />;
  }
  render(
    <MantineProvider>
      <QueryClientProvider client={queryClient}>
        <Page />
      </QueryClientProvider>
    </MantineProvider>,
  );
}

test.each(Object.keys(MODULES))("the form of %s has a field for each parameter that is not for planning", (module) => {
  show(module);
  const shown = (MODULES[module] ?? []).filter((one) => !one.planning);
  for (const { key } of shown) {
    const starts = (text: string) => text === key || text.startsWith(`${key} `);
    expect(screen.getAllByText(starts).length).toBeGreaterThan(0);
  }
});

test("numbers are parsed, a minus sign may be typed first, and cleared fields are omitted", async () => {
  const said = vi.fn();
  show("jog_base", said);
  const field = screen.getByLabelText(/^dx/);
  await userEvent.type(field, "-0.1");
  expect(field).toHaveValue("-0.1");
  expect(said).toHaveBeenLastCalledWith({ dx: -0.1 });
  await userEvent.clear(field);
  expect(said).toHaveBeenLastCalledWith({});
});

test("faults are shown at their fields", async () => {
  show("jog_joints");
  await userEvent.type(screen.getByLabelText(/^deltas/), "0.1 x");
  expect(screen.getByText(/of the wrong type/)).toBeInTheDocument();
});

test("Enter adds a text to a list", async () => {
  const said = vi.fn();
  show("choose", said);
  await userEvent.type(screen.getByPlaceholderText("Type one and press Enter"), "red{Enter}blue{Enter}");
  expect(said).toHaveBeenLastCalledWith({ options: ["red", "blue"] });
});
