import { VisuallyHidden } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useShownView } from "../useShownView";
import { nameNow } from "../../widgets/names";

/** The content of the view in words. */
export function Summary({ id }: { id: string }) {
  const { t } = useTranslation("scene3d");
  const view = useShownView();
  if (view === null) return null;
  const elements = [...view.elements.values()];
  const robots = elements.filter((element) => element.kind === "robot");
  const said = robots.map(({ id, place }) =>
    place === null ? id : t("summary.robot", { robot: nameNow(id), place: nameNow(place) }),
  );
  const count = elements.filter((element) => element.shape !== null).length;
  const unsure = elements.filter(
    ({ pose, place, held_by }) => pose === null && place !== null && held_by === null,
  ).length;
  return (
    <VisuallyHidden id={id}>
      {[...said, t("summary.things", { count }), t("summary.unsure", { count: unsure })].join(", ")}.{" "}
      {t("summary.keys")}
    </VisuallyHidden>
  );
}
