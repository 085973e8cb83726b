import { DataList, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { ElementName } from "../../widgets/ElementName";
import { spoken } from "../../widgets/names";
import type { Details } from "../queries";
import { useWords } from "../useWords";
import { written } from "../values";

/** The place, owner and pose of an element. */
export function Whereabouts({ element }: { element: Details }) {
  const { t } = useTranslation("world");
  const words = useWords();
  const { placement, owner, map_pose: pose } = element;
  return (
    <DataList size="sm" labelWidth={110} aria-label={t("where.label")}>
      {placement && (
        <DataList.Item>
          <DataList.ItemLabel>{t("where.placement")}</DataList.ItemLabel>
          <DataList.ItemValue>
            <Text size="sm" span mr={6}>
              {spoken(placement.relation)}
            </Text>
            <ElementName id={placement.place} />
          </DataList.ItemValue>
        </DataList.Item>
      )}
      {owner && (
        <DataList.Item>
          <DataList.ItemLabel>{t("where.owner")}</DataList.ItemLabel>
          <DataList.ItemValue>
            <ElementName id={owner} />
          </DataList.ItemValue>
        </DataList.Item>
      )}
      <DataList.Item>
        <DataList.ItemLabel>{t("where.pose")}</DataList.ItemLabel>
        <DataList.ItemValue>{pose ? written(pose, words) : t("where.unknown")}</DataList.ItemValue>
      </DataList.Item>
    </DataList>
  );
}
