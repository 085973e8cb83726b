import { useTranslation } from "react-i18next";
import { useSkills } from "../api/cell";
import type { Schema } from "../api/client";
import { ElementName } from "../widgets/ElementName";
import { stepPieces } from "./steps";

/** A step of a plan as a sentence with clickable elements. */
export function StepText({ step }: { step: Pick<Schema<"PlannedStep">, "skill" | "arguments"> }) {
  const { t } = useTranslation("goal");
  const skill = useSkills().get(step.skill);
  const pieces = stepPieces(step, t("steps", { returnObjects: true }), skill?.parameters);
  return (
    <span>
      {pieces.map((piece, index) => ("id" in piece ? <ElementName key={index} id={piece.id} /> : piece.text))}
    </span>
  );
}
