import { useRef } from "react";
import classes from "./Overlay.module.css";
import { useCompass } from "./compassAxes";

const COLOURS = { x: "#e03131", y: "#2f9e44", z: "#1c7ed6" } as const;
const AXES = ["x", "y", "z"] as const;

/** Directions of the map's axes. */
export function Compass() {
  const picture = useRef<SVGSVGElement>(null);
  useCompass(picture);
  return (
    <svg ref={picture} className={classes.compass} width={64} height={64} viewBox="-32 -32 64 64" aria-hidden>
      {AXES.map((axis) => (
        <g key={axis} data-axis={axis} stroke={COLOURS[axis]} fill={COLOURS[axis]}>
          <line x1={0} y1={0} x2={0} y2={0} />
          <text stroke="none">{axis}</text>
        </g>
      ))}
    </svg>
  );
}
