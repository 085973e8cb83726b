import { useComputedColorScheme } from "@mantine/core";
import { Canvas } from "@react-three/fiber";
import { useTranslation } from "react-i18next";
import { Labels } from "./overlay/Labels";
import { paletteOf } from "./palette";
import { quality } from "./quality";
import classes from "./Scene.module.css";
import { Stage } from "./Stage";

const CAMERA = { fov: 38, near: 0.1, far: 80, up: [0, 0, 1] as const, position: [4, -7, 6] as const };

/** The live 3D view: robots, things, and what there is to know about where they are. */
export default function Scene() {
  const { t } = useTranslation("scene3d");
  const scheme = useComputedColorScheme();
  const { dpr, antialias } = quality();
  return (
    <div className={classes.scene}>
      <div className={classes.picture} data-picture role="application" aria-label={t("picture")} tabIndex={0}>
        <Canvas
          flat
          frameloop="demand"
          dpr={dpr}
          gl={{ antialias, powerPreference: "high-performance" }}
          camera={{ ...CAMERA, up: [...CAMERA.up], position: [...CAMERA.position] }}
        >
          <Stage palette={paletteOf(scheme)} />
        </Canvas>
      </div>
      <Labels />
    </div>
  );
}
