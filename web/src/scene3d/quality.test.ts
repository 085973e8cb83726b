import { expect, it } from "vitest";
import { qualityOf } from "./quality";

it("software rendering costs little", () => {
  const name = "ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero)), SwiftShader driver)";
  expect(qualityOf(name)).toMatchObject({ software: true, dpr: 1, antialias: false });
  expect(qualityOf("ANGLE (NVIDIA GeForce RTX)")).toMatchObject({ software: false, antialias: true });
});
