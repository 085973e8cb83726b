import { Anchor, Button } from "@mantine/core";
import { IconQuestionMark } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { Answers } from "./Answers";
import { Banner } from "./Banner";
import { useDialogs } from "./dialogs";
import { type Alarm, useAlarms } from "./useAlarms";
import { ServerText } from "../goal/ServerText";

const SHOWN = 2;

/** Questions of robots and held jobs, with buttons for the answers. */
export function QuestionBanners() {
  const { t } = useTranslation("always");
  const open = useDialogs((dialogs) => dialogs.open);
  const asking = useAlarms(true).filter(({ choices }) => choices.length > 0);
  const more = asking.length - SHOWN;
  return (
    <>
      {asking.slice(0, SHOWN).map((alarm) => (
        <QuestionBanner key={alarm.id} alarm={alarm} />
      ))}
      {more > 0 && (
        <Button variant="light" color="orange" fullWidth onClick={() => open("alarms")}>
          {t("question.more", { count: more })}
        </Button>
      )}
    </>
  );
}

function QuestionBanner({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  const title = alarm.kind === "job" ? t("question.job") : t("question.robot");
  return (
    <Banner tone="orange" icon={IconQuestionMark} title={title} actions={<Answers alarm={alarm} />}>
      <ServerText text={alarm.text} />{" "}
      {alarm.job && (
        <Anchor size="sm" c="inherit" underline="always" href={`#/task/${encodeURIComponent(alarm.job)}`}>
          {t("question.look", { job: alarm.job })}
        </Anchor>
      )}
    </Banner>
  );
}
