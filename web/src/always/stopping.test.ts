import { stopAll, useStopping } from "./stopping";

const INFO = { halted: true, why: "", by: "", since: null, standing: true };

function answer(status: number, body: object): Response {
  return new Response(JSON.stringify(body), { status });
}

/** Makes the server give these answers in order, then repeat the last one. */
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

test("an effective stop is reported", async () => {
  const fetch = answers(answer(200, { ...INFO, obeyed: true }));
  const stopping = stopAll("a person is in the cell");
  await vi.advanceTimersByTimeAsync(100);
  await stopping;
  expect(useStopping.getState().verdict).toBe("obeyed");
  expect(fetch.mock.calls[0]?.[1]).toMatchObject({ method: "POST", keepalive: true });
});

test("a stop without an answer is repeated until there is one", async () => {
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

test("a stop that was received but has no effect yet is not reported as a success", async () => {
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

test("a refused stop shows the server's reason, and is not repeated", async () => {
  const fetch = answers(answer(403, { title: "Role too low", detail: "that takes the role operator" }));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(5000);
  await stopping;
  expect(useStopping.getState()).toMatchObject({ verdict: "refused", text: "that takes the role operator" });
  expect(fetch).toHaveBeenCalledTimes(1);
});

test("a stop that failed because the login had ended is offered again after the next login", async () => {
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

test("a login without a pending stop offers none", () => {
  useStopping.getState().signedIn();
  expect(useStopping.getState().verdict).toBeNull();
});

test("a withdrawn stop is not repeated", async () => {
  const fetch = answers(new TypeError("no network"));
  const stopping = stopAll("why");
  await vi.advanceTimersByTimeAsync(1);
  useStopping.getState().forget();
  await vi.advanceTimersByTimeAsync(5000);
  await stopping;
  expect(useStopping.getState().verdict).toBeNull();
  expect(fetch).toHaveBeenCalledTimes(1);
});

test("a late answer counts, even after further attempts", async () => {
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
