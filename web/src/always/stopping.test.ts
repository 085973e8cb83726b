import { stopAll, useStopping } from "./stopping";

const INFO = { halted: true, why: "", by: "", since: null, standing: true };

function answer(status: number, body: object): Response {
  return new Response(JSON.stringify(body), { status });
}

/** Has the server answer in a certain order; what is asked for more often gets the last answer again. */
function answers(...all: (Response | Error)[]) {
  const left = [...all];
  return vi.spyOn(globalThis, "fetch").mockImplementation(() => {
    const next = left.length > 1 ? left.shift() : left[0];
    return next instanceof Response ? Promise.resolve(next.clone()) : Promise.reject(next ?? new Error());
  });
}

beforeEach(() => {
  vi.useFakeTimers();
  useStopping.getState().forget();
});
afterEach(() => {
  useStopping.getState().forget();
  vi.useRealTimers();
});

test("a stop that was obeyed says so", async () => {
  const fetch = answers(answer(200, { ...INFO, obeyed: true }));
  const stopping = stopAll("a person is in the cell");
  await vi.advanceTimersByTimeAsync(100);
  await stopping;
  expect(useStopping.getState().verdict).toBe("obeyed");
  expect(fetch.mock.calls[0]?.[1]).toMatchObject({ method: "POST", keepalive: true });
});

test("a stop that nobody answers is asked for until somebody does", async () => {
  const fetch = answers(new TypeError("no network"), answer(502, {}), answer(200, { ...INFO, obeyed: true }));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(1);
  expect(useStopping.getState().verdict).toBe("noAnswer");
  await vi.advanceTimersByTimeAsync(2100);
  expect(useStopping.getState().verdict).toBe("noAnswer");
  await vi.advanceTimersByTimeAsync(2100);
  await stopping;
  expect(useStopping.getState().verdict).toBe("obeyed");
  expect(fetch).toHaveBeenCalledTimes(3);
});

test("a stop that was heard and not obeyed is no good news until it is", async () => {
  answers(
    answer(202, { ...INFO, obeyed: false }),
    answer(200, { ...INFO, obeyed: false }),
    answer(200, { ...INFO, obeyed: true }),
  );
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(1500);
  expect(useStopping.getState().verdict).toBe("notObeyed");
  await vi.advanceTimersByTimeAsync(1500);
  await stopping;
  expect(useStopping.getState().verdict).toBe("obeyed");
});

test("a stop that is refused says what the server says, and is not tried again", async () => {
  const fetch = answers(answer(403, { title: "Role too low", detail: "that takes the role operator" }));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(5000);
  await stopping;
  expect(useStopping.getState()).toMatchObject({ verdict: "refused", text: "that takes the role operator" });
  expect(fetch).toHaveBeenCalledTimes(1);
});

test("a stop that nobody takes, since the login has ended, is asked about after the next one, and sent if still wanted", async () => {
  const fetch = answers(
    answer(401, { detail: "send it as 'Authorization: Bearer sk_…'" }),
    answer(200, { ...INFO, obeyed: true }),
  );
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(100);
  await stopping;
  expect(useStopping.getState()).toMatchObject({ verdict: "signedOut", text: "" });
  useStopping.getState().signedIn();
  await vi.advanceTimersByTimeAsync(5000);
  expect(useStopping.getState().verdict).toBe("unsent");
  expect(fetch).toHaveBeenCalledTimes(1);
  const again = stopAll("why");
  await vi.advanceTimersByTimeAsync(100);
  await again;
  expect(useStopping.getState().verdict).toBe("obeyed");
});

test("who signs in without having asked for a stop is asked for none", () => {
  useStopping.getState().signedIn();
  expect(useStopping.getState().verdict).toBeNull();
});

test("a stop that is withdrawn is tried no more", async () => {
  const fetch = answers(new TypeError("no network"));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(1);
  useStopping.getState().forget();
  await vi.advanceTimersByTimeAsync(5000);
  await stopping;
  expect(useStopping.getState().verdict).toBeNull();
  expect(fetch).toHaveBeenCalledTimes(1);
});

test("an answer that comes late is one, though it was tried again meanwhile", async () => {
  let late: (response: Response) => void = () => undefined;
  const fetch = vi.spyOn(globalThis, "fetch").mockReturnValue(new Promise(() => undefined));
  fetch.mockReturnValueOnce(new Promise((resolve) => (late = resolve)));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(1600);
  expect(useStopping.getState().verdict).toBe("noAnswer");
  await vi.advanceTimersByTimeAsync(1000);
  expect(fetch).toHaveBeenCalledTimes(2);
  late(answer(200, { ...INFO, obeyed: true }));
  await vi.advanceTimersByTimeAsync(100);
  await stopping;
  expect(useStopping.getState().verdict).toBe("obeyed");
});
