import {
  ActionIcon,
  type ComboboxData,
  type ComboboxItem,
  type ComboboxParsedItem,
  Group,
  Loader,
  Select,
  Text,
  Tooltip,
} from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconClick } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { type Pick, useSelection } from "../selection/selection";
import { type Candidate, type Candidates, idsOf, useCandidates } from "./candidates";
import { useClassLabels, useElementName } from "./names";
import { notifyProblem } from "./problems";

interface Props {
  label: string;
  /** Class of the offered elements ("sk:Container"). */
  class_: string;
  value: string | null;
  onChange: (id: string | null) => void;
  /** Also offers abstract individuals and classes: "any starter". */
  abstract?: boolean;
  required?: boolean;
  error?: string | undefined;
  /** Text below the field. */
  description?: string | undefined;
  disabled?: boolean;
  /** In a line of text: the label is hidden, except from screen readers. */
  inline?: boolean;
  /** In a table: the label is hidden, except from screen readers, and the field fills the cell. */
  hideLabel?: boolean;
}

const TYPING = 150; // ms

/** Chooses an element of a class: by name, or by a click in the 3D view or the tree. */
export function ElementPicker(props: Props) {
  const {
    label,
    class_,
    value,
    onChange,
    abstract = false,
    required,
    error,
    description,
    disabled,
    inline,
    hideLabel,
  } = props;
  const { t } = useTranslation();
  const chosen = useChosen(value);
  const [search, setSearch] = useState("");
  const [opened, setOpened] = useState(false);
  const [asked] = useDebouncedValue(search === chosen ? "" : search.trim(), TYPING);
  const { candidates, isFetching } = useCandidates(class_, abstract, asked, opened);
  const kinds = new Map([...candidates.elements, ...candidates.described].map((one) => [one.value, one.kind]));
  const titles = {
    kinds: t("pick.kinds"),
    here: t("pick.here"),
    described: t("pick.described"),
    more: t("pick.more"),
  };
  // The server has filtered already; only the chosen option, which is always included, may not match.
  const found = (options: ComboboxParsedItem[]) =>
    asked === "" ? options : options.filter((one) => !isAlone(one, value));
  const data = grouped({ candidates, titles, any: (kind) => t("pick.any", { class: kind }) });
  return (
    <Group gap={2} align={inline ? "center" : "end"} wrap="nowrap" flex={inline ? undefined : 1}>
      <Select
        flex={inline ? undefined : 1}
        w={inline ? `${Math.min(Math.max(chosen.length, 9) + 6, 30)}ch` : undefined}
        label={inline || hideLabel ? undefined : label}
        aria-label={label}
        description={description}
        placeholder={t("pick.choose")}
        data={withValue(data, value, chosen)}
        value={value}
        onChange={onChange}
        searchable
        searchValue={search}
        onSearchChange={setSearch}
        onDropdownOpen={() => setOpened(true)}
        onDropdownClose={() => setOpened(false)}
        onFocus={(event) => event.currentTarget.select()}
        filter={({ options }) => found(options)}
        allowDeselect={false}
        renderOption={({ option }) => <Offer option={option} kind={kinds.get(option.value)} />}
        clearable={!required && !inline}
        withAsterisk={required}
        error={error}
        disabled={disabled}
        maxDropdownHeight={320}
        comboboxProps={{ width: "max-content", position: "bottom-start", shadow: "md" }}
        nothingFoundMessage={isFetching ? t("loading") : t("pick.empty")}
        rightSection={isFetching && opened ? <Loader size={12} /> : undefined}
      />
      <PickButton label={label} class_={class_} take={onChange} disabled={disabled} />
    </Group>
  );
}

/** Returns the label of the chosen option. */
function useChosen(value: string | null): string {
  const { t } = useTranslation();
  const name = useElementName(value);
  const class_ = useClassLabels().get(value ?? "");
  if (value === null || value === "") return "";
  return name ?? t("pick.any", { class: class_ ?? value });
}

function Offer({ option, kind }: { option: ComboboxItem; kind: string | undefined }) {
  return (
    <Group gap="md" justify="space-between" wrap="nowrap" w="100%">
      <span>{option.label}</span>
      {kind && (
        <Text span size="xs" c="dimmed">
          {kind}
        </Text>
      )}
    </Group>
  );
}

interface Offered {
  candidates: Candidates;
  /** The heading of a group of candidates. */
  titles: { kinds: string; here: string; described: string; more: string };
  /** "any starter". */
  any: (class_: string) => string;
}

function grouped({ candidates, titles, any }: Offered): ComboboxData {
  const { classes, elements, described, more } = candidates;
  const rest = more ? [{ value: "", label: titles.more, disabled: true }] : [];
  const groups = [
    { group: titles.kinds, items: classes.map(({ value, label }) => ({ value, label: any(label) })) },
    { group: titles.here, items: [...elements, ...rest] },
    { group: titles.described, items: described },
  ].filter(({ items }) => items.length > 0);
  return groups.length > 1 ? groups : (groups[0]?.items ?? []);
}

/** The chosen value must be among the options, or its label could not be shown. */
function withValue(data: ComboboxData, value: string | null, label: string): ComboboxData {
  if (!value || listed(data).some((one) => one.value === value)) return data;
  const missing = { value, label };
  return [{ group: "", items: [missing] }, ...data];
}

/** Whether this is the option added for the chosen value, see withValue. */
function isAlone(option: ComboboxParsedItem, value: string | null): boolean {
  return "group" in option && option.group === "" && option.items.some((one) => "value" in one && one.value === value);
}

function listed(data: ComboboxData): Candidate[] {
  return data.flatMap((one) => (typeof one === "object" && "items" in one ? one.items : [one])) as Candidate[];
}

interface PickButtonProps {
  label: string;
  class_: string;
  take: (id: string) => void;
  disabled?: boolean | undefined;
}

/** Waits for a click on an element of the class; pressing it again cancels. */
function PickButton({ label, class_, take, disabled }: PickButtonProps) {
  const { t } = useTranslation();
  const [mine, setMine] = useState<Pick | null>(null);
  const waiting = useSelection(({ pick }) => pick !== null && pick === mine);
  const latest = useLatest(take);
  useEffect(() => () => endPick(mine), [mine]);
  const begin = async () => {
    const ids = await idsOf(class_);
    if (latest.current === null) return; // the form was closed
    const pick = { purpose: label, fits: (id: string) => ids.has(id), take: (id: string) => latest.current?.(id) };
    setMine(pick);
    useSelection.getState().awaitPick(pick);
  };
  const toggle = () => (waiting ? endPick(mine) : void begin().catch(notifyProblem));
  return (
    <Tooltip label={t("pick.inView")}>
      <ActionIcon
        aria-label={`${label}: ${t("pick.inView")}`}
        aria-pressed={waiting}
        variant={waiting ? "filled" : "subtle"}
        onClick={toggle}
        disabled={disabled}
      >
        <IconClick size={16} aria-hidden />
      </ActionIcon>
    </Tooltip>
  );
}

/** Calls the latest callback, so that later input in the form is kept. */
function useLatest<Action>(action: Action) {
  const latest = useRef<Action | null>(null);
  useEffect(() => {
    latest.current = action;
  });
  useEffect(() => () => void (latest.current = null), []);
  return latest;
}

function endPick(pick: Pick | null): void {
  const { pick: awaited, endPick: end } = useSelection.getState();
  if (pick !== null && awaited === pick) end();
}
