import { Accordion } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Changes } from "../changes/Changes";
import { Locks } from "../locks/Locks";
import classes from "../World.module.css";
import { LearnedList } from "./LearnedList";
import { Present } from "./Present";
import { SceneList } from "./SceneList";
import { Simulation } from "./Simulation";

const PARTS = {
  present: Present,
  scenes: SceneList,
  simulation: Simulation,
  changes: Changes,
  learned: LearnedList,
  locks: Locks,
} as const;
type PartName = keyof typeof PARTS;
const OPEN: PartName[] = ["present", "scenes", "simulation"];

/** Scenes, simulation, changes, learned concepts and locks. */
export default function ScenesView() {
  const { t } = useTranslation("world");
  return (
    <div className={classes.scroll}>
      <Accordion multiple defaultValue={OPEN} variant="separated" keepMounted={false}>
        {(Object.keys(PARTS) as PartName[]).map((name) => {
          const Content = PARTS[name];
          return (
            <Accordion.Item key={name} value={name}>
              <Accordion.Control>{t(`scenes.parts.${name}`)}</Accordion.Control>
              <Accordion.Panel>
                <Content />
              </Accordion.Panel>
            </Accordion.Item>
          );
        })}
      </Accordion>
    </div>
  );
}
