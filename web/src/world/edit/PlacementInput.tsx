import { Select, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useMemo } from "react";
import { useTranslation } from "react-i18next";
import { keys } from "../../api/keys";
import { ElementPicker } from "../../widgets/ElementPicker";
import { Status } from "../../widgets/Status";
import { useClasses } from "../classes";
import { type Placement, useRelations } from "../queries";
import { askFits, type Guest, placeEnd, placementsFor } from "./placements";

interface Props {
  /** The element to place. */
  guest: Guest;
  /** Its class. */
  class_: string;
  value: Placement | null;
  onChange: (value: Placement | null) => void;
  error?: ReactNode;
}

/** Chooses relation and place, and shows whether the place accepts the element, and why not. */
export function PlacementInput({ guest, class_, value, onChange, error }: Props) {
  const { t } = useTranslation("world");
  const classes = useClasses();
  const { data: relations } = useRelations();
  const options = useMemo(() => placementsFor(classes, relations ?? [], class_), [classes, relations, class_]);
  const chosen = options.find(({ name }) => name === value?.relation) ?? options[0];
  if (chosen === undefined) return <Text size="sm">{t("placement.nowhere")}</Text>;
  const place = value?.place ?? null;
  return (
    <Stack gap={4}>
      <Select
        label={t("placement.relation")}
        data={options.map(({ name, label }) => ({ value: name, label: `${label} (${name})` }))}
        value={chosen.name}
        allowDeselect={false}
        onChange={(relation) => relation && onChange({ relation, place: place ?? "" })}
      />
      <ElementPicker
        label={t("placement.place")}
        class_={placeEnd(chosen)[0]?.[0] ?? "sk:Element"}
        value={place || null}
        onChange={(id) => onChange(id === null ? null : { relation: chosen.name, place: id })}
      />
      {place && <Fits guest={guest} place={place} relation={chosen.name} />}
      {error && (
        <Text size="xs" c="red" role="alert">
          {error}
        </Text>
      )}
    </Stack>
  );
}

function Fits({ guest, place, relation }: { guest: Guest; place: string; relation: string }) {
  const { t } = useTranslation("world");
  const { data } = useQuery({
    queryKey: keys.world("fits", guest, place, relation),
    queryFn: async () => (await askFits(guest, place, [relation]))[0] ?? null,
  });
  if (data === undefined) return null;
  if (data?.fits) return <Status mood="good" text={t("placement.fits")} />;
  return (
    <Text size="xs" role="status">
      <Status mood="bad" text={t("placement.fitsNot")} /> {data?.whyNot ?? t("placement.wrongClass")}
    </Text>
  );
}
