import { MantineProvider } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { act, render, screen } from "@testing-library/react";
import { expect, test, vi } from "vitest";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import "../i18n";
import { useConnection } from "../live/connection";
import { type StationState, useStation } from "../live/station";
import { RobotsState, StationClock } from "./StationStates";

vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));

function show(node: React.ReactNode) {
  queryClient.setQueryData(keys.robots(), [{ id: "robot_1", label: "robot", devices: [] }]);
  render(
    <MantineProvider>
      <QueryClientProvider client={queryClient}>{node}</QueryClientProvider>
    </MantineProvider>,
  );
}

const state = (time: number) => ({ time, pace: 1, devices: {}, tasks: [], modules: [] }) as unknown as StationState;

test("a robot is not said to stand while the server is lost", () => {
  vi.stubGlobal("fetch", () => new Promise(() => undefined));
  useConnection.setState({ status: "open", since: null, silent: null });
  useStation.getState().take(state(1));
  show(<RobotsState />);
  expect(screen.getByText("robot not moving")).toBeTruthy();
  act(() => useConnection.setState({ status: "lost", since: 0 }));
  expect(screen.queryByText("robot not moving")).toBeNull();
  expect(screen.getByText("unknown whether robots move")).toBeTruthy();
});

test("the pace that is reached is shown where it is not the wanted one", () => {
  const now = vi.spyOn(performance, "now");
  show(<StationClock />);
  for (const [at, time] of [
    [1e6, 10],
    [1e6 + 1500, 10.15],
    [1e6 + 3000, 10.3],
  ] as const) {
    now.mockReturnValue(at);
    act(() => useStation.getState().take(state(time)));
  }
  expect(screen.getByRole("timer").textContent).toBe("0:10 simulated × 0.1 instead of × 1");
});
