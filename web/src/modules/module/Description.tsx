import { Accordion, Code, List, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { said } from "../../i18n/sentences";
import type { Schema } from "../../api/client";

/** The description of a module: its conditions in words, and its implementations. */
export function Description({ details }: { details: Schema<"ModuleDetails"> }) {
  const { t } = useTranslation("modules");
  if (details.kind === "primitive") return <Outputs outputs={details.outputs} />;
  return (
    <Stack gap="sm">
      <Outputs outputs={details.outputs} />
      <Accordion multiple variant="separated">
        <Accordion.Item value="conditions">
          <Accordion.Control>{t("description.conditions")}</Accordion.Control>
          <Accordion.Panel>
            <Stack gap="xs">
              {(["pre", "hold", "post"] as const).map((kind) => (
                <Conditions key={kind} title={t(`panel.${kind}`)} conditions={details[kind]} />
              ))}
            </Stack>
          </Accordion.Panel>
        </Accordion.Item>
        <Accordion.Item value="ways">
          <Accordion.Control>{t("description.ways", { count: details.implementations.length })}</Accordion.Control>
          <Accordion.Panel>
            <Stack gap="sm">
              {details.implementations.map((way) => (
                <Way key={`${way.label} ${way.driver} ${way.order}`} way={way} />
              ))}
            </Stack>
          </Accordion.Panel>
        </Accordion.Item>
      </Accordion>
    </Stack>
  );
}

function Outputs({ outputs }: { outputs: Schema<"ModuleOutput">[] }) {
  const { t } = useTranslation("modules");
  if (outputs.length === 0) return null;
  return (
    <div>
      <Text size="sm" fw={600}>
        {t("description.outputs")}
      </Text>
      <List size="sm">
        {outputs.map(({ name, type, unit, help }) => (
          <List.Item key={name}>
            {[name, type, unit].filter(Boolean).join(" · ")}{" "}
            <Text span c="dimmed" inherit>
              {said(help)}
            </Text>
          </List.Item>
        ))}
      </List>
    </div>
  );
}

function Conditions({ title, conditions }: { title: string; conditions: Schema<"SkillCondition">[] }) {
  if (conditions.length === 0) return null;
  return (
    <div>
      <Text size="sm" fw={600}>
        {title}
      </Text>
      <List size="sm">
        {conditions.map((condition) => (
          <List.Item key={condition.text}>
            {condition.text}{" "}
            <Text span c="dimmed" inherit>
              {said(condition.words)}
            </Text>
          </List.Item>
        ))}
      </List>
    </div>
  );
}

function Way({ way }: { way: Schema<"Implementation"> }) {
  const { t } = useTranslation("modules");
  const title = [way.label, way.version, way.driver && t("description.driver", { driver: way.driver })];
  return (
    <div>
      <Text size="sm" fw={600}>
        {title.filter(Boolean).join(" · ")}
      </Text>
      {way.requires.length > 0 && (
        <Text size="xs">{t("description.requires", { classes: way.requires.join(", ") })}</Text>
      )}
      {way.when.map((condition) => (
        <Text key={condition.text} size="xs">
          {t("description.when", { condition: condition.text })}
        </Text>
      ))}
      {way.nodes.length > 0 && <Code block>{way.nodes.map(indented).join("\n")}</Code>}
    </div>
  );
}

function indented({ path, title }: Schema<"BodyNode">): string {
  return "  ".repeat(path.split("/").length - 1) + title;
}
