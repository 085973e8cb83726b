import { Group, Tooltip } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { MayButton } from "../widgets/MayButton";
import { type Alarm, useAnswer } from "./useAlarms";

/** Answers that the server knows, and what each means; skills may ask for others, which are shown as they are. */
const KNOWN = {
  retry: "retry",
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

/** A button for each answer that an alarm waits for. */
export function Answers({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  const answering = useAnswer();
  return (
    <Group gap={6} role="group" aria-label={t("answers.label", { text: alarm.text })}>
      {alarm.choices.map((choice) => {
        const known = isKnown(choice) ? KNOWN[choice] : undefined;
        return (
          <Tooltip key={choice} label={known && t(`answers.${known}.means`)} disabled={!known} multiline maw={280}>
            <span>
              <MayButton
                operation="answer_alarm"
                variant={choice === alarm.choices[0] ? "filled" : "default"}
                loading={answering.isPending && answering.variables.choice === choice}
                disabled={answering.isPending}
                onClick={() => answering.mutate({ alarm, choice })}
              >
                {known ? t(`answers.${known}.label`) : choice}
              </MayButton>
            </span>
          </Tooltip>
        );
      })}
    </Group>
  );
}
