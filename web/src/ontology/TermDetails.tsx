import { Stack } from "@mantine/core";
import { useTranslation } from "react-i18next";
import type { PropertyInfo, RelationInfo } from "../world/queries";
import { Fact, Facts, Head } from "./Facts";
import { TermLinks } from "./TermLinks";

/** The ontology's description of a relation. */
export function RelationDetails({ relation }: { relation: RelationInfo }) {
  const { t } = useTranslation(["ontology", "common"]);
  const inverse = relation.inverse === null ? [] : [relation.inverse];
  return (
    <Stack component="section" gap="xs" aria-label={relation.label}>
      <Head {...relation} />
      <Facts>
        <Fact label={t("relation.family")}>{relation.computed ? t("relation.computed") : relation.family}</Fact>
        <Fact label={t("relation.subjects")}>
          <Groups groups={relation.subjects} />
        </Fact>
        <Fact label={t("relation.objects")}>
          <Groups groups={relation.objects} />
        </Fact>
        <Fact label={t("relation.parents")}>
          <TermLinks names={relation.parents} />
        </Fact>
        <Fact label={t("relation.inverse")}>
          <TermLinks names={inverse} />
        </Fact>
        <Fact label={t("relation.functional")}>{relation.functional ? t("yes") : t("no")}</Fact>
      </Facts>
    </Stack>
  );
}

/** The ontology's description of a property. */
export function PropertyDetails({ property }: { property: PropertyInfo }) {
  const { t } = useTranslation(["ontology", "common"]);
  return (
    <Stack component="section" gap="xs" aria-label={property.label}>
      <Head {...property} />
      <Facts>
        <Fact label={t("property.datatype")}>
          {property.datatype} – {property.says}
        </Fact>
        <Fact label={t("property.unit")}>{property.unit || t("common:none")}</Fact>
        <Fact label={t("property.borneBy")}>
          <Groups groups={property.borne_by} />
        </Fact>
      </Facts>
    </Stack>
  );
}

/** At least one class of each group is required. */
function Groups({ groups }: { groups: readonly (readonly string[])[] }) {
  const { t } = useTranslation(["ontology", "common"]);
  if (groups.length === 0) return t("anything");
  return groups.map((group, index) => (
    <div key={group.join(" ")}>
      {index > 0 && `${t("and")} `}
      <TermLinks names={group} />
    </div>
  ));
}
