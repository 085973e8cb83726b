import { Accordion, Loader, Stack, Table, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { lazy, Suspense } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { ElementName } from "../widgets/ElementName";
import { problemText } from "../widgets/problems";
import { useWords } from "../world/useWords";
import { written } from "../world/values";
import { Fact, Facts, Head } from "./Facts";
import { TermLinks } from "./TermLinks";

const NeighbourGraph = lazy(() => import("./NeighbourGraph"));

type Details = Schema<"ClassDetails">;

/** The ontology's description of a class, and its uses. */
export function ClassDetails({ name }: { name: string }) {
  const { t } = useTranslation(["ontology", "common"]);
  const { data, error } = useQuery({
    queryKey: keys.world("class", name), // its answer contains numbers of elements
    queryFn: () => answer(api.GET("/api/v1/ontology/classes/{name}", { params: { path: { name } } })),
  });
  if (error) return <Text size="sm">{problemText(error)}</Text>;
  if (data === undefined) return <Loader size="sm" aria-label={t("reading")} />;
  return (
    <Stack component="section" gap="xs" aria-label={data.label}>
      <Head {...data} />
      <Basics class_={data} />
      <Parts class_={data} />
    </Stack>
  );
}

function Basics({ class_ }: { class_: Details }) {
  const { t } = useTranslation(["ontology", "common"]);
  const direct = class_.subclasses.filter((name) => name !== class_.name);
  return (
    <Facts>
      <Fact label={t("class.parents")}>
        <TermLinks names={class_.parents} />
      </Fact>
      <Fact label={t("class.below")}>
        <TermLinks names={direct} />
      </Fact>
      <Fact label={t("class.instances", { count: class_.instances })}>
        <Elements ids={class_.some_instances} more={class_.instances - class_.some_instances.length} />
      </Fact>
      {class_.individuals.length > 0 && (
        <Fact label={t("class.individuals")}>
          <Elements ids={class_.individuals} more={0} />
        </Fact>
      )}
    </Facts>
  );
}

function Elements({ ids, more }: { ids: readonly string[]; more: number }) {
  const { t } = useTranslation(["ontology", "common"]);
  if (ids.length === 0) return t("common:none");
  return (
    <Text size="sm" component="span">
      {ids.map((id) => (
        <span key={id}>
          <ElementName id={id} />{" "}
        </span>
      ))}
      {more > 0 && t("class.more", { count: more })}
    </Text>
  );
}

function Parts({ class_ }: { class_: Details }) {
  const { t } = useTranslation(["ontology", "common"]);
  const { properties, relations_from: from, relations_to: to, how_many: numbers, skills, conditions } = class_;
  return (
    <Accordion multiple defaultValue={["uses"]} keepMounted={false}>
      <Section name="uses" title={t("class.uses", { count: skills.length + conditions.length })}>
        <Uses title={t("class.skills")} uses={skills} />
        <Uses title={t("class.conditions")} uses={conditions} />
      </Section>
      <Section name="properties" title={t("class.properties", { count: properties.length })}>
        <Properties properties={properties} />
      </Section>
      <Section name="relations" title={t("class.relations", { count: from.length + to.length })}>
        <Facts>
          <Fact label={t("class.from")}>
            <TermLinks names={from} />
          </Fact>
          <Fact label={t("class.to")}>
            <TermLinks names={to} />
          </Fact>
          {numbers.length > 0 && (
            <Fact label={t("class.howMany")}>
              {numbers.map((one) => (
                <div key={`${one.relation} ${one.of}`}>{numberText(one)}</div>
              ))}
            </Fact>
          )}
        </Facts>
      </Section>
      <Section name="graph" title={t("class.graph")}>
        <Suspense fallback={<Loader size="sm" />}>
          <NeighbourGraph class_={class_} />
        </Suspense>
      </Section>
    </Accordion>
  );
}

function Section({ name, title, children }: { name: string; title: string; children: React.ReactNode }) {
  return (
    <Accordion.Item value={name}>
      <Accordion.Control>{title}</Accordion.Control>
      <Accordion.Panel>{children}</Accordion.Panel>
    </Accordion.Item>
  );
}

function numberText({ relation, least, most, of }: Schema<"HowMany">): string {
  const range = least === most ? String(least) : `${least} – ${most ?? "∞"}`;
  return `${relation}: ${range}${of ? ` ${of}` : ""}`;
}

function Uses({ title, uses }: { title: string; uses: readonly Schema<"ClassUse">[] }) {
  if (uses.length === 0) return null;
  return (
    <Table aria-label={title} verticalSpacing={2}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th colSpan={3}>{title}</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {uses.map((use) => (
          <Table.Tr key={`${use.name} ${use.argument}`}>
            <Table.Td>{use.name}</Table.Td>
            <Table.Td>{use.argument}</Table.Td>
            <Table.Td>
              <TermLinks names={[use.class]} />
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Properties({ properties }: { properties: Details["properties"] }) {
  const { t } = useTranslation(["ontology", "common"]);
  const words = useWords();
  return (
    <Table aria-label={t("lists.properties")} verticalSpacing={2}>
      <Table.Tbody>
        {properties.map(({ name, comment, unit, value }) => (
          <Table.Tr key={name}>
            <Table.Th scope="row">
              <TermLinks names={[name]} />
            </Table.Th>
            <Table.Td>
              <Text size="xs">{comment}</Text>
            </Table.Td>
            <Table.Td>
              {value !== null && (
                <Text size="xs" lineClamp={2}>
                  {written(value, words)} {typeof value === "number" && unit}
                </Text>
              )}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}
