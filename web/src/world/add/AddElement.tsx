import { Button, Fieldset, Group, Modal, Select, Stack, TextInput } from "@mantine/core";
import { type SyntheticEvent, useMemo } from "react";
import { useTranslation } from "react-i18next";
import { useSelection } from "../../selection/selection";
import { MayButton } from "../../widgets/MayButton";
import { PlacementInput } from "../edit/PlacementInput";
import { PropertyFields } from "../edit/PropertyFields";
import { Refused } from "../edit/Refused";
import { Unfit } from "../edit/Unfit";
import type { Details, Placement } from "../queries";
import { LABEL, PLACEMENT } from "../edit/draft";
import { useOptions } from "./options";
import { type Adding, useAdding } from "./useAdding";

interface Props {
  /** Proposed place; null for none. */
  parent: Details | null;
  /** The element that is copied. */
  like?: Details;
  onClose: () => void;
}

/** Adds an element at a place: of a class that fits there, or a copy. */
export function AddElement({ parent, like, onClose }: Props) {
  const { t } = useTranslation(["world", "common"]);
  const adding = useAdding(parent, like, onClose);
  const picking = useSelection(({ pick }) => pick !== null); // makes room for picking the place
  const title = like ? t("add.copyOf", { label: like.label }) : t("add.title");
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    event.stopPropagation();
    adding.save();
  };
  return (
    <Modal opened={!picking} keepMounted onClose={onClose} title={title} size="lg">
      <form onSubmit={submit} aria-label={title}>
        <Stack gap="xs">
          <Refused lines={adding.rest} />
          {like === undefined && <WhatPicker parent={parent} adding={adding} />}
          {adding.class_ && <Fields adding={adding} class_={adding.class_} copy={like !== undefined} />}
          <Group justify="end">
            <Unfit fields={adding.unfit} class_={adding.class_} />
            <Button variant="default" onClick={onClose}>
              {t("common:cancel")}
            </Button>
            <MayButton
              operation="add_element"
              type="submit"
              loading={adding.saving}
              disabled={!adding.class_ || adding.unfit.length > 0}
            >
              {t("common:add")}
            </MayButton>
          </Group>
        </Stack>
      </form>
    </Modal>
  );
}

function WhatPicker({ parent, adding }: { parent: Details | null; adding: Adding }) {
  const { t } = useTranslation(["world", "common"]);
  const options = useOptions(parent);
  const groups = useMemo(
    () => [
      { group: t("add.ofClass"), items: options.classes },
      { group: t("add.copies"), items: options.copies },
    ],
    [options, t],
  );
  return (
    <Select
      label={t("add.what")}
      description={parent ? t("add.fitting", { label: parent.label }) : undefined}
      data={groups}
      searchable
      data-autofocus
      nothingFoundMessage={t("add.nothingFits")}
      value={adding.what}
      onChange={(value) => adding.choose(value, options.classOf(value))}
      maxDropdownHeight={300}
    />
  );
}

function Fields({ adding, class_, copy }: { adding: Adding; class_: string; copy: boolean }) {
  const { t } = useTranslation(["world", "common"]);
  const { draft, setDraft, errors } = adding;
  return (
    <>
      <TextInput
        label={t("edit.name")}
        placeholder={copy ? undefined : t("add.nameOfClass")}
        value={String(draft[LABEL] ?? "")}
        error={errors[LABEL]}
        onChange={(event) => setDraft({ ...draft, [LABEL]: event.currentTarget.value })}
      />
      <Fieldset legend={t("edit.placement")} p="xs">
        <PlacementInput
          guest={{ class: class_ }}
          class_={class_}
          value={(draft[PLACEMENT] as Placement | null | undefined) ?? null}
          error={errors[PLACEMENT]}
          onChange={(value) => setDraft({ ...draft, [PLACEMENT]: value })}
        />
      </Fieldset>
      <PropertyFields class_={class_} draft={draft} onChange={setDraft} errors={errors} />
      <TextInput
        label={t("edit.reason")}
        description={t("edit.reasonHelp")}
        value={adding.reason}
        onChange={(event) => adding.setReason(event.currentTarget.value)}
      />
    </>
  );
}
