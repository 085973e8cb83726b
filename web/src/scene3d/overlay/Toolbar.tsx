import { ActionIcon, Menu, Tooltip } from "@mantine/core";
import {
  IconAxisX,
  IconBox,
  IconChartDots3,
  IconFocus2,
  IconGhost2,
  IconGrid4x4,
  IconHome,
  IconRobot,
  IconRoute,
  IconScan,
  IconStack2,
  IconTag,
  type TablerIcon,
  IconSquareToggle,
} from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useSelection } from "../../selection/selection";
import { useCamera, type Viewpoint } from "../camera/camera";
import { type Layer, LAYERS, useLayers } from "../layers";
import classes from "./Overlay.module.css";

const VIEWPOINTS: Record<Viewpoint, TablerIcon> = {
  overview: IconHome,
  top: IconSquareToggle,
  follow: IconRobot,
  selection: IconFocus2,
};

const LAYER_ICONS: Record<Layer, TablerIcon> = {
  labels: IconTag,
  rooms: IconBox,
  clouds: IconChartDots3,
  seen: IconScan,
  paths: IconRoute,
  ghosts: IconGhost2,
  axes: IconAxisX,
  grid: IconGrid4x4,
};

/** Viewpoints and layers. */
export function Toolbar() {
  const { t } = useTranslation("scene3d");
  return (
    <div role="toolbar" aria-label={t("toolbar")} aria-orientation="vertical" className={classes.toolbar}>
      {Object.entries(VIEWPOINTS).map(([name, Icon]) => (
        <LookButton key={name} viewpoint={name as Viewpoint} Icon={Icon} />
      ))}
      <LayersMenu />
    </div>
  );
}

function LookButton({ viewpoint, Icon }: { viewpoint: Viewpoint; Icon: TablerIcon }) {
  const { t } = useTranslation("scene3d");
  const follows = useCamera((camera) => camera.viewpoint === "follow" && viewpoint === "follow");
  const look = useCamera((camera) => camera.look);
  const nothing = useSelection(({ selected }) => viewpoint === "selection" && selected === null);
  const name = t(`look.${viewpoint}`);
  return (
    <Tooltip label={name} position="right">
      <ActionIcon
        variant={follows ? "filled" : "default"}
        aria-label={name}
        aria-pressed={viewpoint === "follow" ? follows : undefined}
        disabled={nothing}
        onClick={() => look(viewpoint)}
      >
        <Icon size={18} />
      </ActionIcon>
    </Tooltip>
  );
}

function LayersMenu() {
  const { t } = useTranslation("scene3d");
  const { shown, toggle } = useLayers();
  return (
    <Menu position="right-start" closeOnItemClick={false} withinPortal>
      <Menu.Target>
        <Tooltip label={t("layers.title")} position="right">
          <ActionIcon variant="default" aria-label={t("layers.title")}>
            <IconStack2 size={18} />
          </ActionIcon>
        </Tooltip>
      </Menu.Target>
      <Menu.Dropdown aria-label={t("layers.title")}>
        {LAYERS.map((layer) => {
          const Icon = LAYER_ICONS[layer];
          return (
            <Menu.CheckboxItem
              key={layer}
              checked={shown[layer]}
              onChange={() => toggle(layer)}
              rightSection={<Icon size={16} aria-hidden />}
            >
              {t(`layers.${layer}`)}
            </Menu.CheckboxItem>
          );
        })}
      </Menu.Dropdown>
    </Menu>
  );
}
