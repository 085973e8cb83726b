import { Alert } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { intoView } from "../../widgets/intoView";

/** Refusals that concern no single field; scrolled into view, since the Save button may be far below. */
export function Refused({ lines }: { lines: readonly string[] }) {
  const { t } = useTranslation("world");
  if (lines.length === 0) return null;
  return (
    <Alert ref={intoView} color="red" role="alert" title={t("edit.refused")} style={{ overflowWrap: "anywhere" }}>
      {lines.map((line) => (
        <div key={line}>{line}</div>
      ))}
    </Alert>
  );
}
