import { MantineProvider } from "@mantine/core";
import { render, screen } from "@testing-library/react";
import "../../i18n";
import { SignalPanel } from "./SignalPanel";
import type { Signal } from "./traces";

const FORCE: Signal = {
  name: "wrist_1.force",
  unit: "N",
  dimension: "force",
  length: 3,
  frame: "map",
  help: "",
  source: "wrist_1",
  input: false,
};

beforeAll(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
});

function show(signal: Signal) {
  const reading = { value: 12, cycle: 1, source: signal.source, reason: "" };
  const traces = { time: 1, cycle: 1, signals: { [signal.name]: reading }, points: {} };
  render(
    <MantineProvider>
      <SignalPanel signal={signal} traces={traces} />
    </MantineProvider>,
  );
}

test("a signal is shown with unit, dimension and frame", () => {
  show(FORCE);
  expect(screen.getByText("12 N")).toBeVisible();
  expect(screen.getByText("force · in frame map")).toBeVisible();
});

test("a signal whose unit has no known dimension is shown without one", () => {
  show({ ...FORCE, unit: "", dimension: "" });
  expect(screen.getByText("in frame map")).toBeVisible();
});
