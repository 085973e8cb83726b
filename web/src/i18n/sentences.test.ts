import i18n from ".";
import { emitEvent, type EventInfo } from "../live/events";
import { learn, said } from "./sentences";

const IN_KIT = {
  template: "{subject} is not {relation} {object}",
  values: { subject: "starter_1", relation: "held by", object: "gripper_1" },
};
const SENTENCE = "starter_1 is not held by gripper_1";

afterEach(() => i18n.changeLanguage("en"));

test("a sentence of an answer is said in the language of the pages, sentences in it too", async () => {
  const held = { template: "job {job}: {detail}", values: { job: "kit-17", detail: IN_KIT } };
  learn({ items: [{ texts: { [`job kit-17: ${SENTENCE}`]: held, [SENTENCE]: IN_KIT } }] });
  await i18n.changeLanguage("de");
  expect(said(SENTENCE)).toMatch(/^starter_1 .* nicht gehalten von gripper_1$/);
  expect(said(`job kit-17: ${SENTENCE}`)).toBe(`Auftrag kit-17: ${said(SENTENCE)}`);
});

test("a sentence of an event is said in the language of the pages, numbers with a decimal comma", async () => {
  const parts = { template: "stopped {distance} m and {turned} deg off {location}", values: {} };
  const values = { distance: "0.052", turned: "1.5", location: "pallet_a" };
  emitEvent({ data: { texts: { far: { ...parts, values } } } } as unknown as EventInfo);
  await i18n.changeLanguage("de");
  expect(said("far")).toBe("hielt 0,052 m und 1,5° neben pallet_a");
});

test("a sentence without values is known by its text, and a relation by its name in the ontology", async () => {
  const stated = { subject: "kit_1", relation: "sk:on", object: "table" };
  learn({ texts: { stated: { template: "states {subject} {relation} {object}", values: stated } } });
  await i18n.changeLanguage("de");
  expect(said("restarts")).toBe("Neustart");
  expect(said("stated")).toBe("eingetragen: kit_1 auf table");
});

test("sentences that the pages do not know stay as the server says them", async () => {
  learn({ texts: { "the belt runs dry": { template: "the {what} runs dry", values: { what: "belt" } } } });
  await i18n.changeLanguage("de");
  expect(said("the belt runs dry")).toBe("the belt runs dry");
  expect(said("never heard")).toBe("never heard");
});
