import { MantineProvider } from "@mantine/core";
import { fireEvent, render, screen } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import "../../i18n";
import { NumberField } from "./NumberField";

beforeEach(() => {
  vi.stubGlobal("matchMedia", () => ({ matches: false, addEventListener() {}, removeEventListener() {} }));
});

function show(first: number | undefined) {
  function Page() {
    const [value, setValue] = useState(first);
    return (
      <MantineProvider>
        <NumberField label="x" unit="m" step={0.01} value={value} onChange={setValue} />
        <output>{String(value)}</output>
      </MantineProvider>
    );
  }
  render(<Page />);
  return { field: screen.getByLabelText("x"), value: screen.getByRole("status") };
}

test.each([undefined, 0.4, 1.5])("inserting a number equals typing it (field contained %s)", (first) => {
  const { field, value } = show(first);
  fireEvent.change(field, { target: { value: "1,5" } });
  expect(value).toHaveTextContent(/^1.5$/);
  expect(field).toHaveValue("1,5");
});

test("pasting equals typing", async () => {
  const { field, value } = show(undefined);
  await userEvent.click(field);
  await userEvent.paste("-1,25");
  expect(value).toHaveTextContent(/^-1.25$/);
});

test("a text that is not a number shows a fault and yields no other number", () => {
  const { field, value } = show(0.4);
  fireEvent.change(field, { target: { value: "1e999" } });
  expect(value).toHaveTextContent("NaN");
  expect(field).toHaveValue("1e999");
  expect(field).toBeInvalid();
  expect(screen.getByText(/1e999/)).toBeInTheDocument();
});

test("the arrow keys step, and a cleared field is empty", async () => {
  const { field, value } = show(0.4);
  await userEvent.type(field, "{ArrowUp}{ArrowUp}{ArrowDown}");
  expect(value).toHaveTextContent(/^0.41$/);
  await userEvent.clear(field);
  expect(field).toHaveValue("");
  expect(value).toHaveTextContent("undefined");
});
