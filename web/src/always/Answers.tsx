import { Group, Text, Tooltip } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useStation } from "../live/station";
import { MayButton } from "../widgets/MayButton";
import { type Alarm, useAnswer } from "./useAlarms";
import { said } from "../i18n/sentences";

/** Known answers with their meanings; skills may ask for others, which are shown unchanged. */
const KNOWN = {
  retry: "retry",
  "look again": "lookAgain",
  "done by hand": "byHand",
  skip: "skip",
  abort: "abort",
  yes: "yes",
  no: "no",
  done: "done",
  cannot: "cannot",
} as const;

type Known = keyof typeof KNOWN;

function isKnown(choice: string): choice is Known {
  return Object.hasOwn(KNOWN, choice);
}

/** A button for each possible answer to an alarm. */
export function Answers({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  const answering = useAnswer();
  const halted = useStation(({ state }) => Boolean(state?.halted));
  return (
    <Group gap={6} role="group" aria-label={t("answers.label", { text: said(alarm.text) })}>
      {alarm.choices.map((choice) => {
        const known = isKnown(choice) ? KNOWN[choice] : undefined;
        const early = halted && known === "retry"; // the robots cannot move before a reset
        const means = early ? t("answers.early") : known && t(`answers.${known}.means`);
        return (
          <Tooltip key={choice} label={means} disabled={!means} multiline maw={280}>
            <span>
              <MayButton
                operation="answer_alarm"
                variant={choice === alarm.choices[0] && !halted ? "filled" : "default"}
                loading={answering.isPending && answering.variables.choice === choice}
                disabled={answering.isPending || early}
                onClick={() => answering.mutate({ alarm, choice })}
              >
                {known ? t(`answers.${known}.label`) : choice}
              </MayButton>
            </span>
          </Tooltip>
        );
      })}
      {halted && alarm.choices.includes("retry") && <Text size="xs">{t("answers.early")}</Text>}
    </Group>
  );
}
