import { Loader, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import classes from "../modules.module.css";
import type { Place, View } from "../places";
import { useModules } from "../queries";
import { ModuleList } from "./ModuleList";
import { ModulePage } from "./ModulePage";

interface Props {
  place: Place;
  show: (view: View, ...rest: string[]) => void;
}

/** The list of modules, and the chosen one. */
export function TryModules({ place, show }: Props) {
  const { t } = useTranslation("modules");
  const { data: modules = [], isPending } = useModules();
  const [agent, name] = place.rest;
  const chosen = modules.find((module) => module.name === name);
  const choose = (module: string, who: string) => show("try", who, module);
  const doer = chosen?.agents.find((one) => one.agent === agent)?.agent ?? chosen?.agents[0]?.agent;
  return (
    <div className={classes.split} data-chosen={name === undefined ? undefined : true}>
      <nav className={classes.list} aria-label={t("list.label")}>
        <ModuleList modules={modules} chosen={name} choose={choose} />
      </nav>
      <section className={classes.details} aria-label={t("details")}>
        {isPending && <Loader size="sm" aria-label={t("loading", { ns: "common" })} />}
        {chosen && doer !== undefined ? (
          <ModulePage
            key={`${doer}/${chosen.name}`}
            module={chosen}
            agent={doer}
            choose={choose}
            back={() => show("try")}
            show={show}
          />
        ) : (
          <Text c="dimmed" size="sm" hidden={isPending}>
            {name !== undefined ? t("list.unknown", { name }) : t("list.choose")}
          </Text>
        )}
      </section>
    </div>
  );
}
