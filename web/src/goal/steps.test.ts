import { clock, doneOf, stepPieces } from "./steps";

const DRIVE = { skill: "drive", arguments: { Base: "base_1", Robot: "robot_1", Location: "pallet_a" } };
const PICK = { skill: "pick", arguments: { Robot: "robot_1", Object: "starter_1" } };

function run(step: typeof DRIVE | typeof PICK, ended: string | null = "ended") {
  return { ...step, ended };
}

test("a step is described by the sentence of its skill", () => {
  const pieces = stepPieces(DRIVE, { drive: "{Robot} drives to {Location}" });
  expect(pieces).toEqual([{ id: "robot_1" }, { text: " drives to " }, { id: "pallet_a" }]);
});

test("a step without a fitting sentence is described by its arguments, without devices", () => {
  const plain = [
    { text: "drive" },
    { text: " Robot: " },
    { id: "robot_1" },
    { text: " Location: " },
    { id: "pallet_a" },
  ];
  const parameters = [
    { key: "Base", kind: "hardware" },
    { key: "Robot", kind: "planning" },
    { key: "Location", kind: "online" },
  ];
  expect(stepPieces(DRIVE, {}, parameters)).toEqual(plain);
  expect(stepPieces(DRIVE, { drive: "{Robot} drives to {Elsewhere}" }, parameters)).toEqual(plain);
});

test("devices are recognised by the skill's description, not by parameter names", () => {
  const dock = { skill: "dock", arguments: { Wheels: "omni_1", Base: "plinth_1" } };
  const parameters = [
    { key: "Wheels", kind: "hardware" },
    { key: "Base", kind: "online" },
  ];
  expect(stepPieces(dock, {}, parameters)).toEqual([{ text: "dock" }, { text: " Base: " }, { id: "plinth_1" }]);
});

test("each step that ran counts once; failed and running ones do not count", () => {
  const plan = [DRIVE, PICK, DRIVE];
  expect(doneOf(plan, [run(DRIVE), run(PICK, "failed"), run(DRIVE, null)])).toBe(1);
  expect(doneOf(plan, [run(DRIVE), run(PICK), run(DRIVE)])).toBe(3);
});

test("seconds are written as minutes", () => {
  expect(clock(65.4)).toBe("1:05");
});
