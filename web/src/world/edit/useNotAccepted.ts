import { useTranslation } from "react-i18next";
import { useClass } from "../queries";
import { useWords } from "../useWords";
import { kindOf, written } from "../values";
import { type Draft, PLACEMENT } from "./draft";

/** Returns a function with the text for a field whose value has no accepted form, with the expected one. */
export function useNotAccepted(class_: string | null, draft: Draft): (field: string) => string {
  const { t } = useTranslation("world");
  const words = useWords();
  const { data } = useClass(class_);
  const kind = (field: string) =>
    field === PLACEMENT ? "place" : kindOf(data?.properties.find(({ name }) => name === field)?.datatype ?? "");
  return (field) =>
    t("edit.notAccepted", { value: written(draft[field], words), expected: t(`edit.expected.${kind(field)}`) });
}
