import { MantineProvider } from "@mantine/core";
import { render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import "../../i18n";
import { CountField } from "./CountField";

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
});

function Rounds({ first }: { first: number }) {
  const [rounds, setRounds] = useState(first);
  return (
    <MantineProvider>
      <CountField label="Rounds" min={-20} max={100} value={rounds} onChange={setRounds} />
      <output>{rounds}</output>
    </MantineProvider>
  );
}

test("clearing the field and typing a number gives that number", async () => {
  const user = userEvent.setup();
  render(<Rounds first={1} />);
  const field = screen.getByLabelText("Rounds");
  await user.clear(field);
  expect(screen.getByRole("status")).toHaveTextContent("1");
  await user.type(field, "5");
  expect(screen.getByRole("status")).toHaveTextContent(/^5$/);
  await user.clear(field);
  await user.type(field, "-12");
  expect(screen.getByRole("status")).toHaveTextContent(/^-12$/);
});

test("a field left empty shows the value in force", async () => {
  const user = userEvent.setup();
  render(<Rounds first={7} />);
  const field = screen.getByLabelText("Rounds");
  await user.clear(field);
  await user.tab();
  expect(field).toHaveValue("7");
});

test("a value beyond the limits becomes the limit", async () => {
  const user = userEvent.setup();
  render(<Rounds first={1} />);
  await user.type(screen.getByLabelText("Rounds"), "234");
  expect(screen.getByRole("status")).toHaveTextContent(/^100$/);
});
