/** The texts of the pages in English and German, one file for each part of the pages. */

import i18n from "i18next";
import { initReactI18next } from "react-i18next";
import * as de from "./de";
import * as en from "./en";
import { isolated } from "./isolated";

export const LANGUAGES = { en: "English", de: "Deutsch" } as const;
export type Language = keyof typeof LANGUAGES;

const REMEMBERED = "skiros-language";

declare module "i18next" {
  interface CustomTypeOptions {
    defaultNS: "common";
    resources: typeof en;
  }
}

function wanted(): Language {
  const said = localStorage.getItem(REMEMBERED) ?? navigator.language.slice(0, 2);
  return said === "de" ? "de" : "en";
}

void i18n.use(initReactI18next).init({
  lng: wanted(),
  fallbackLng: "en",
  defaultNS: "common",
  resources: { en, de },
  interpolation: { escapeValue: true, escape: isolated }, // React escapes HTML
});

i18n.on("languageChanged", (language) => {
  localStorage.setItem(REMEMBERED, language);
  document.documentElement.lang = language;
});
document.documentElement.lang = i18n.language;

export default i18n;
