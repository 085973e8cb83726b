/** Which dialog of those that are always there is open; buttons, keys and the command palette open them alike. */

import { create } from "zustand";

export type Dialog = "reset" | "alarms" | "help" | "load";

interface Dialogs {
  opened: Dialog | null;
  /** Name of what it is about: the scene that is to be loaded. */
  about: string;
  open: (dialog: Dialog, about?: string) => void;
  close: () => void;
}

export const useDialogs = create<Dialogs>((set) => ({
  opened: null,
  about: "",
  open: (opened, about = "") => set({ opened, about }),
  close: () => set({ opened: null }),
}));
