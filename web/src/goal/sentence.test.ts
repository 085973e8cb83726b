import { piecesOf, plainSentence, sentenceOfHelp } from "./sentence";

const OBJECT = { name: "object", class: "sk:Manipulatable", reached: "sk:Manipulatable" };
const LOCATION = { name: "location", class: "sk:Container", reached: "sk:Container" };

test("a sentence has a slot for each role", () => {
  expect(piecesOf("{object} lies in {location}", [OBJECT, LOCATION])).toEqual([0, " lies in ", 1]);
});

test("a role that the sentence does not name gets a slot at the end, and repeated roles get one slot", () => {
  expect(piecesOf("{object} lies, {object} rests", [OBJECT, LOCATION])).toEqual([
    0,
    " lies, ",
    "object",
    " rests",
    ", location:",
    1,
  ]);
});

test("help text becomes a sentence by the names or classes of its roles", () => {
  const help = "The object lies in the container.";
  expect(sentenceOfHelp({ help, roles: [OBJECT, LOCATION] })).toBe("{object} lies in {location}");
});

test("help text that omits a role makes no sentence", () => {
  const roles = [
    { name: "whole", class: "sk:SpatialThing", reached: "sk:SpatialThing" },
    { name: "part", class: "sk:SpatialThing", reached: "sk:SpatialThing" },
  ];
  expect(sentenceOfHelp({ help: "One thing is built of another.", roles })).toBeNull();
  expect(plainSentence({ name: "HasPart", roles })).toBe("HasPart: whole: {whole}, part: {part}");
});
