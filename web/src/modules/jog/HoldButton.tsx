import { Button, type ButtonProps } from "@mantine/core";
import { type KeyboardEvent, type PointerEvent, type ReactNode, useEffect, useRef } from "react";
import classes from "../modules.module.css";
import type { Step } from "./jogger";
import { jogger } from "./robotJogger";

interface Props extends ButtonProps {
  /** Starts a step; the next one follows while the button, or Enter or Space on it, is held. */
  step: Step;
  /** The label for screen readers. */
  name: string;
  children: ReactNode;
}

/** Moves while it is held: a click is one step; losing the pointer or the focus ends the motion. */
export function HoldButton({ step, name, children, ...rest }: Props) {
  const held = useRef(false);
  const press = () => {
    held.current = true;
    jogger.hold(step);
  };
  const release = () => {
    if (held.current) jogger.release();
    held.current = false;
  };
  useEffect(() => {
    const end = () => document.hidden && release();
    document.addEventListener("visibilitychange", end);
    return () => {
      document.removeEventListener("visibilitychange", end);
      release();
    };
  }, []);
  const pointerDown = (event: PointerEvent<HTMLButtonElement>) => {
    if (event.button !== 0) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    press();
  };
  const keyDown = (event: KeyboardEvent) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    if (event.ctrlKey || event.metaKey || event.altKey) return; // other shortcuts
    event.preventDefault();
    if (!event.repeat) press();
  };
  return (
    <Button
      variant="default"
      {...rest}
      className={classes.hold}
      aria-label={name}
      onPointerDown={pointerDown}
      onPointerUp={release}
      onPointerCancel={release}
      onLostPointerCapture={release}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={keyDown}
      onKeyUp={release}
      onBlur={release}
      onClick={(event) => event.detail === 0 && jogger.once(step)} // from assistive technology, without a press
    >
      {children}
    </Button>
  );
}
