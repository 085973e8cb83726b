import { MantineProvider } from "@mantine/core";
import { QueryClientProvider } from "@tanstack/react-query";
import { render, screen } from "@testing-library/react";
import i18n from "../i18n";
import type { Schema } from "../api/client";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { learn } from "../i18n/sentences";
import { Paused } from "./Paused";

const AT = "2026-11-20T09:30:00Z";
const FULL = "the disk is full: nothing was changed";

function page(text: string, choices: string[], comment: string) {
  const job = { id: "kit", version: 3, state: { text }, choices } as unknown as Schema<"Job">;
  const items = [{ at: AT, trigger: "hold", state: { text }, comment }];
  queryClient.setQueryData(keys.jobs("transitions", "kit", 3, text), { items });
  return (
    <MantineProvider>
      <QueryClientProvider client={queryClient}>
        <Paused job={job} />
      </QueryClientProvider>
    </MantineProvider>
  );
}

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
  vi.stubGlobal("fetch", () => Promise.reject(new Error("no server")));
  learn({ texts: { [FULL]: { template: FULL, values: {} } } });
});

afterEach(() => i18n.changeLanguage("en"));

test("a job paused by a full disk says since when and why, in the language of the pages", async () => {
  await i18n.changeLanguage("de");
  render(page("Interrupted", [], FULL));
  expect(screen.getByRole("status")).toHaveTextContent(/angehalten um .*: .*Platte/);
  expect(screen.getByRole("status").querySelector("time")).toHaveAttribute("datetime", "2026-11-20T09:30:00.000Z");
});

test("a job that runs, or that asks a person, says nothing of a pause", () => {
  render(page("Running", [], ""));
  render(page("Interrupted", ["retry"], FULL));
  expect(screen.queryByRole("status")).toBeNull();
});
