import { Alert, Button, Group, Text } from "@mantine/core";
import type { TFunction } from "i18next";
import { useTranslation } from "react-i18next";
import type { Skills } from "../api/cell";
import { type Conflict, type Edit, onto, type Sequence } from "./sequences";
import { stepTitle } from "./words";

interface Props {
  conflict: Conflict;
  skills: Skills;
  again: (edit: Edit) => void;
  drop: () => void;
}

/** Another person has changed the sequence: shows the differences and asks what to do. */
export function ConflictAlert({ conflict, skills, again, drop }: Props) {
  const { t } = useTranslation("task");
  const possible = onto(conflict);
  const { seen, there } = conflict;
  return (
    <Alert color="orange" role="alert" title={t("conflict.title")} p="xs">
      <Versions seen={seen} there={there} skills={skills} />
      <Text size="sm">{t("conflict.wanted", { edit: editText(t, conflict, skills) })}</Text>
      {possible === null && <Text size="sm">{t("conflict.impossible")}</Text>}
      <Group gap="xs" mt={4}>
        <Button variant="default" onClick={drop}>
          {t("conflict.drop")}
        </Button>
        {possible !== null && <Button onClick={() => again(possible)}>{t("conflict.again")}</Button>}
      </Group>
    </Alert>
  );
}

/** The step as it was displayed, and as it is now. */
export function Versions({ seen, there, skills }: Pick<Conflict, "seen" | "there"> & Pick<Props, "skills">) {
  const { t } = useTranslation("task");
  return (
    <>
      <Text size="sm">{t("conflict.seen", { version: seen.version, steps: titles(seen, skills) })}</Text>
      <Text size="sm">{t("conflict.there", { version: there.version, steps: titles(there, skills) })}</Text>
    </>
  );
}

function titles(sequence: Sequence, skills: Skills): string {
  return sequence.steps.map((step) => stepTitle(step, skills)).join(", ") || "–";
}

function editText(t: TFunction<"task">, { edit, seen }: Conflict, skills: Skills): string {
  const about = seen.steps[edit.at];
  const step = about === undefined ? "" : stepTitle(about, skills);
  switch (edit.kind) {
    case "insert":
      return t("conflict.insert", { step: stepTitle({ arguments: {}, ...edit.step }, skills) });
    case "remove":
      return t("conflict.remove", { step });
    case "move":
      return t("conflict.move", { step, to: edit.to + 1 });
  }
}
