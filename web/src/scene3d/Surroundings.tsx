import { useEffect, useMemo } from "react";
import { GridHelper, type Material } from "three";
import { useLayers } from "./layers";
import type { Palette } from "./palette";
import { quality } from "./quality";

const WIDE = 30; // m

/** Light, fog, and a grid of one metre on the floor. */
export function Surroundings({ palette }: { palette: Palette }) {
  const grid = useLayers(({ shown }) => shown.grid);
  return (
    <>
      <color attach="background" args={[palette.background]} />
      <fog attach="fog" args={[palette.background, 12, 30]} />
      <hemisphereLight args={[palette.sky, palette.ground, 2.1]} position={[0, 0, 1]} />
      <directionalLight position={[-3, -5, 8]} intensity={1.5} />
      {!quality().software && <directionalLight position={[6, 4, 5]} intensity={0.5} />}
      {grid && <Grid palette={palette} />}
    </>
  );
}

function Grid({ palette }: { palette: Palette }) {
  const grid = useMemo(() => {
    const made = new GridHelper(WIDE, WIDE, palette.grid, palette.grid);
    made.rotation.x = Math.PI / 2;
    made.position.z = 0.004;
    return made;
  }, [palette]);
  useEffect(
    () => () => {
      grid.geometry.dispose();
      (grid.material as Material).dispose();
    },
    [grid],
  );
  return <primitive object={grid} />;
}
