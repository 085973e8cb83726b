import { SegmentedControl, Stack, Text, TextInput } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconSearch } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useClasses } from "../world/classes";
import { useProperties, useRelations } from "../world/queries";
import { Split } from "../world/Split";
import { useView } from "../world/useView";
import classes from "../world/World.module.css";
import { ClassDetails } from "./ClassDetails";
import { ClassTree } from "./ClassTree";
import { PropertyDetails, RelationDetails } from "./TermDetails";
import { TermList } from "./TermList";

const LISTS = ["classes", "relations", "properties"] as const;
type ListName = (typeof LISTS)[number];
const SEARCH_PAUSE = 150; // ms

/** Browser for the classes, relations and properties of the ontology; read-only. */
export default function OntologyBrowser() {
  const { t } = useTranslation("ontology");
  return <Split divider={t("divider")} list={<Lists />} details={<Chosen />} />;
}

function Lists() {
  const { t } = useTranslation("ontology");
  const [list, setList] = useState<ListName>("classes");
  const [text, setText] = useState("");
  const [search] = useDebouncedValue(text.trim().toLowerCase(), SEARCH_PAUSE);
  return (
    <Stack gap={6} className={classes.fill}>
      <SegmentedControl
        size="xs"
        aria-label={t("lists.label")}
        value={list}
        onChange={(value) => setList(value as ListName)}
        data={LISTS.map((value) => ({ value, label: t(`lists.${value}`) }))}
      />
      <TextInput
        type="search"
        aria-label={t("search")}
        placeholder={t("search")}
        leftSection={<IconSearch size={14} aria-hidden />}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
      />
      <div className={classes.tree}>
        {list === "classes" && <ClassTree search={search} />}
        {list === "relations" && <Relations search={search} />}
        {list === "properties" && <Properties search={search} />}
      </div>
    </Stack>
  );
}

function Relations({ search }: { search: string }) {
  const { t } = useTranslation("ontology");
  const { data } = useRelations();
  return <TermList label={t("lists.relations")} terms={data ?? []} search={search} />;
}

function Properties({ search }: { search: string }) {
  const { t } = useTranslation("ontology");
  const { data } = useProperties();
  return <TermList label={t("lists.properties")} terms={data ?? []} search={search} />;
}

/** The subject of the address: a class, a relation or a property. */
function Chosen() {
  const { t } = useTranslation("ontology");
  const [, name] = useView();
  const known = useClasses();
  const relation = useRelations().data?.find((one) => one.name === name);
  const property = useProperties().data?.find((one) => one.name === name);
  if (known.has(name)) return <ClassDetails name={name} />;
  if (relation !== undefined) return <RelationDetails relation={relation} />;
  if (property !== undefined) return <PropertyDetails property={property} />;
  return (
    <Text size="sm" c="dimmed">
      {name === "" || known.size === 0 ? t("nothing") : t("unknown", { name })}
    </Text>
  );
}
