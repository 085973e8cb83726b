/** Which global dialog is open; buttons, keys and the command palette open them alike. */

import { create } from "zustand";

export type Dialog = "reset" | "alarms" | "help" | "load";

interface Dialogs {
  opened: Dialog | null;
  /** Its subject: the name of the scene to load. */
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
