import { Anchor, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useSelection } from "../selection/selection";
import { useClassLabels, useElementName } from "./names";

interface Props {
  id: string;
  /** Not clickable, because it is part of a clickable element. */
  plain?: boolean;
}

/** The name of an element, which selects it when clicked; a class is shown as "any …". */
export function ElementName({ id, plain = false }: Props) {
  const { t } = useTranslation();
  const name = useElementName(id);
  const class_ = useClassLabels().get(id);
  const { choose, hover } = useSelection.getState();
  if (name === null)
    return (
      <Text span inherit>
        {t("pick.any", { class: class_ ?? id })}
      </Text>
    );
  if (plain) return <bdi>{name}</bdi>;
  return (
    <Anchor
      component="button"
      type="button"
      inherit
      c="inherit"
      underline="always"
      style={{ textDecorationStyle: "dotted", textUnderlineOffset: 3 }}
      onClick={() => choose(id)}
      onMouseEnter={() => hover(id)}
      onMouseLeave={() => hover(null)}
    >
      <bdi>{name}</bdi>
    </Anchor>
  );
}
