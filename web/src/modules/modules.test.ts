import { EVERYTHING, fitting } from "./filter";
import { detailOf, placeOf } from "./places";
import { quoted } from "../widgets/shell";
import { cliCommand, curlCommand } from "./shellWords";
import type { Summary } from "./queries";

const place = (agent: string) => ({ agent, robot: agent.replace(/^\D+/, "robot_") });
const MODULES: Summary[] = [
  { name: "drive", kind: "skill", help: "Drives to a place.", version: "1", agents: [place("base_1")] },
  { name: "home", kind: "primitive", help: "Folds arms.", version: "1", agents: [place("arm_1"), place("base_2")] },
  { name: "pick", kind: "skill", help: "Takes a part.", version: "1", agents: [place("arm_1")] },
];
const names = (found: Summary[]) => found.map(({ name }) => name);

test("skills come first, and all words must match", () => {
  expect(names(fitting(MODULES, EVERYTHING))).toEqual(["drive", "pick", "home"]);
  expect(names(fitting(MODULES, { ...EVERYTHING, text: "ARM fold" }))).toEqual(["home"]);
  expect(names(fitting(MODULES, { ...EVERYTHING, kind: "skill", text: "part" }))).toEqual(["pick"]);
  expect(names(fitting(MODULES, { ...EVERYTHING, robot: "robot_2" }))).toEqual(["home"]);
});

test("an address names a view, and an unknown view opens the list", () => {
  expect(placeOf(detailOf("try", "arm_1", "pick"))).toEqual({ view: "try", rest: ["arm_1", "pick"] });
  expect(placeOf("nowhere/at/all")).toEqual({ view: "try", rest: [] });
  expect(placeOf("")).toEqual({ view: "try", rest: [] });
});

test("the command line has the command's own notation of values, quoted for the shell", () => {
  const values = { question: "Is it Anna's; ok?", options: ["red", "blue"], patience: 2 };
  expect(cliCommand({ agent: "arm_1", module: "choose", values, repeat: 3 })).toBe(
    "skiros module run choose --agent arm_1 --param 'question=Is it Anna'\\''s; ok?'" +
      ` --param 'options=["red","blue"]' --param patience=2 --repeat 3`,
  );
  expect(quoted("$(rm -rf)")).toBe("'$(rm -rf)'");
});

test("the request contains module and arguments, and a key only if one is required", () => {
  const wanted = { agent: "base_1", module: "drive", values: { Location: "pallet_a" }, repeat: 1 };
  const open = curlCommand(wanted, "http://here:8000", false);
  expect(open).toBe(
    "curl http://here:8000/api/v1/modules/base_1/drive/runs -H 'Content-Type: application/json'" +
      ` -d '{"arguments":{"Location":"pallet_a"},"repeat":1}'`,
  );
  expect(curlCommand(wanted, "", true)).toContain('"Authorization: Bearer $SKIROS_KEY"');
});
