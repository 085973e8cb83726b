/** Moving a robot by hand: one small step after the other while a button is held; it can be stopped at any time. */

import { create } from "zustand";
import type { Run } from "../queries";

/** Starts one step; it is over when its run is. */
export interface Step {
  (): Promise<Run>;
  /** What it has done when it succeeded, for people; the module's own words where it is missing. */
  done?: string;
}

/** The step with words for what it has done. */
export function told(step: Step, done: string): Step {
  return Object.assign(() => step(), { done });
}

/** How steps are followed and stopped: the server, or a script in tests. */
export interface Follower {
  /** Resolves when a run is over. */
  over: (id: string) => Promise<Run>;
  stop: (id: string) => Promise<unknown>;
}

export interface Said {
  good: boolean;
  text: string;
}

interface Hand {
  /** Whether a step is under way. */
  moving: boolean;
  /** How the last step ended; null before the first one. */
  said: Said | null;
}

/** The steps to come, until there are none or the button is released. */
interface Wish {
  next: () => Step | null;
  /** Goes on after the first step only while held. */
  held: boolean;
  steps: number;
}

export function makeHand(follower: Follower, words: (error: unknown) => string) {
  const useHand = create<Hand>(() => ({ moving: false, said: null }));
  let wish: Wish | null = null;
  let current: string | null = null;
  let stopped = false;

  /** Does steps until there are no more; what is under way ends first. */
  function begin(next: () => Step | null, held: boolean): void {
    wish = { next, held, steps: 0 };
    if (!useHand.getState().moving) void work();
  }

  async function work(): Promise<void> {
    useHand.setState({ moving: true, said: null });
    while (wish !== null && (wish.steps === 0 || wish.held)) {
      const mine = wish;
      const step = mine.next();
      mine.steps += 1;
      if ((step === null || !(await tried(step))) && wish === mine) wish = null;
    }
    wish = null;
    useHand.setState({ moving: false });
  }

  async function tried(step: Step): Promise<boolean> {
    stopped = false;
    try {
      return await good(step);
    } catch (error) {
      useHand.setState({ said: { good: false, text: words(error) } });
      return false;
    } finally {
      current = null;
    }
  }

  async function good(step: Step): Promise<boolean> {
    const { id } = await step();
    current = id;
    if (stopped) await follower.stop(id);
    const run = await follower.over(id);
    const ended = run.status === "succeeded";
    const words = run.rounds.at(-1)?.text ?? run.status;
    useHand.setState({ said: { good: ended, text: (ended && step.done) || words } });
    return ended;
  }

  return {
    useHand,
    /** One step; asked for while another is under way it comes after that. */
    once: (step: Step) => begin(() => step, false),
    /** Steps until they are used up. */
    all: (next: () => Step | null) => begin(next, true),
    /** A step now, and further ones until {@link release}. */
    hold: (step: Step) => begin(() => step, true),
    /** Lets a first step come to its end, so that a click is one step; what came after it is stopped at once. */
    release: () => {
      if (wish === null || !wish.held) return;
      if (wish.steps > 1) void halt();
      else wish.held = false;
    },
    stop: halt,
  };

  /** Stops what is under way, and whatever was to come. */
  async function halt(): Promise<void> {
    stopped = true;
    wish = null;
    if (current === null) return;
    try {
      await follower.stop(current);
    } catch (error) {
      useHand.setState({ said: { good: false, text: words(error) } });
    }
  }
}
