import { QueryClient, QueryClientProvider } from "@tanstack/react-query";
import { fireEvent, render, screen, waitFor } from "@testing-library/react";
import { useSingleMutation } from "./mutations";

function Adder({ add, twice }: { add: () => Promise<string>; twice?: boolean }) {
  const { mutate, status } = useSingleMutation({ mutationFn: add });
  const click = () => {
    mutate();
    if (twice) mutate(); // a double click sends it before the page is rendered again
  };
  return <button onClick={click}>{status}</button>;
}

function show(adder: React.ReactNode) {
  render(<QueryClientProvider client={new QueryClient()}>{adder}</QueryClientProvider>);
}

test("a double click runs it once", async () => {
  const add = vi.fn(() => Promise.resolve("starter_2"));
  show(<Adder add={add} twice />);
  fireEvent.click(screen.getByRole("button"));
  await screen.findByText("success");
  expect(add).toHaveBeenCalledTimes(1);
});

test("it is not started again while it runs, even before the page is rendered", async () => {
  let end: (id: string) => void = () => undefined;
  const add = vi.fn(() => new Promise<string>((resolve) => (end = resolve)));
  show(<Adder add={add} />);
  fireEvent.click(screen.getByRole("button"));
  await screen.findByText("pending");
  fireEvent.click(screen.getByRole("button"));
  end("starter_2");
  await screen.findByText("success");
  expect(add).toHaveBeenCalledTimes(1);
});

test.each([["success"], ["error"]])("after %s it can run again", async (ending) => {
  const add = vi.fn(() => (ending === "success" ? Promise.resolve("") : Promise.reject(new Error("refused"))));
  show(<Adder add={add} />);
  for (const times of [1, 2, 3]) {
    await waitFor(() => {
      fireEvent.click(screen.getByRole("button"));
      expect(add).toHaveBeenCalledTimes(times);
    });
    await screen.findByText(ending);
  }
});
