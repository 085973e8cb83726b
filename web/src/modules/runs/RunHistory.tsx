import { Button, NavLink, Text } from "@mantine/core";
import { IconArrowLeft } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { Moment } from "../../widgets/Moment";
import { Status } from "../../widgets/Status";
import classes from "../modules.module.css";
import type { View } from "../places";
import { type Run, useRuns } from "../queries";
import { RunView } from "./RunView";
import { MOODS } from "./states";

interface Props {
  chosen: string | undefined;
  show: (view: View, ...rest: string[]) => void;
}

/** The single runs since the start of the server, newest first. */
export function RunHistory({ chosen, show }: Props) {
  const { t } = useTranslation("modules");
  const { data: runs = [] } = useRuns();
  return (
    <div className={classes.split} data-chosen={chosen === undefined ? undefined : true}>
      <nav className={classes.list} aria-label={t("run.history")}>
        {runs.length === 0 && <Text size="sm">{t("run.none")}</Text>}
        {runs.map((run) => (
          <Entry key={run.id} run={run} active={run.id === chosen} choose={() => show("runs", run.id)} />
        ))}
      </nav>
      <section className={classes.details} aria-label={t("details")}>
        {chosen !== undefined && (
          <>
            <Button
              className={classes.back}
              variant="subtle"
              size="compact-xs"
              leftSection={<IconArrowLeft size={14} aria-hidden />}
              onClick={() => show("runs")}
            >
              {t("run.back")}
            </Button>
            <RunView id={chosen} />
          </>
        )}
      </section>
    </div>
  );
}

function Entry({ run, active, choose }: { run: Run; active: boolean; choose: () => void }) {
  const { t } = useTranslation("modules");
  return (
    <NavLink
      component="button"
      active={active}
      aria-current={active ? "true" : undefined}
      onClick={choose}
      label={run.module}
      description={
        <>
          {run.agent} · <Moment at={run.started} /> · {run.by}
        </>
      }
      rightSection={<Status mood={MOODS[run.status]} text={t(`run.status.${run.status}`)} />}
    />
  );
}
