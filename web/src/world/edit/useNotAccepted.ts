import { useTranslation } from "react-i18next";
import { useClass } from "../queries";
import { useWords } from "../useWords";
import { kindOf, written } from "../values";
import { type Draft, PLACEMENT } from "./draft";

/** Returns what says of a field that its value is none of its kind, and which would be. */
export function useNotAccepted(class_: string | null, draft: Draft): (field: string) => string {
  const { t } = useTranslation("world");
  const words = useWords();
  const { data } = useClass(class_);
  const kind = (field: string) =>
    field === PLACEMENT ? "place" : kindOf(data?.properties.find(({ name }) => name === field)?.datatype ?? "");
  return (field) =>
    t("edit.notAccepted", { value: written(draft[field], words), expected: t(`edit.expected.${kind(field)}`) });
}
