/** Jogging a robot: one small step after another while a button is held; it can be stopped at any time. */

import { create } from "zustand";
import type { Run } from "../queries";

/** Starts one step; the step ends with its run. */
export interface Step {
  (): Promise<Run>;
  /** The text shown after success; the module's own text if missing. */
  doneText?: string;
}

export function withDoneText(step: Step, doneText: string): Step {
  return Object.assign(() => step(), { doneText });
}

/** Follows and stops the runs of steps: the server, or a script in tests. */
export interface Runner {
  /** Resolves when a run has ended. */
  ended: (id: string) => Promise<Run>;
  stop: (id: string) => Promise<unknown>;
}

export interface StepResult {
  succeeded: boolean;
  text: string;
}

interface State {
  /** Whether a step is running. */
  moving: boolean;
  /** Result of the last step; null before the first one. */
  result: StepResult | null;
}

/** The steps to come, until there are none or the button is released. */
interface Request {
  next: () => Step | null;
  /** Whether steps follow the first one. */
  held: boolean;
  steps: number;
}

export function makeJogger(runner: Runner, errorText: (error: unknown) => string) {
  const useState = create<State>(() => ({ moving: false, result: null }));
  let request: Request | null = null;
  let current: string | null = null;
  let stopped = false;

  /** Replaces the pending request; a running step ends first. */
  function begin(next: () => Step | null, held: boolean): void {
    request = { next, held, steps: 0 };
    if (!useState.getState().moving) void work();
  }

  async function work(): Promise<void> {
    useState.setState({ moving: true, result: null });
    while (request !== null && (request.steps === 0 || request.held)) {
      const mine = request;
      const step = mine.next();
      mine.steps += 1;
      if ((step === null || !(await attempt(step))) && request === mine) request = null;
    }
    request = null;
    useState.setState({ moving: false });
  }

  async function attempt(step: Step): Promise<boolean> {
    stopped = false;
    try {
      return await run(step);
    } catch (error) {
      showError(error);
      return false;
    } finally {
      current = null;
    }
  }

  async function run(step: Step): Promise<boolean> {
    const { id } = await step();
    current = id;
    if (stopped) await runner.stop(id);
    const { status, rounds } = await runner.ended(id);
    const succeeded = status === "succeeded";
    const text = rounds.at(-1)?.text ?? status;
    useState.setState({ result: { succeeded, text: (succeeded && step.doneText) || text } });
    return succeeded;
  }

  function showError(error: unknown): void {
    useState.setState({ result: { succeeded: false, text: errorText(error) } });
  }

  return {
    useState,
    /** One step, after the running one if there is one. */
    once: (step: Step) => begin(() => step, false),
    /** Steps until `next` returns null. */
    all: (next: () => Step | null) => begin(next, true),
    /** A step now, and further ones until {@link release}. */
    hold: (step: Step) => begin(() => step, true),
    /** Lets the first step finish, so that a click is one step; stops any later step at once. */
    release: () => {
      if (request === null || !request.held) return;
      if (request.steps > 1) void halt();
      else request.held = false;
    },
    stop: halt,
  };

  /** Stops the running step and discards the steps to come. */
  async function halt(): Promise<void> {
    stopped = true;
    request = null;
    if (current === null) return;
    try {
      await runner.stop(current);
    } catch (error) {
      showError(error);
    }
  }
}
