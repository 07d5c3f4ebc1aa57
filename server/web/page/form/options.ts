// Parses the options that a user typed, or reports what is wrong, field by field.
import type { Comparison, Direction, Options, Strategy, Tolerance } from "../api/types.js";
import { optionsOf } from "../text/snippets.js";

export type ToleranceKind = "default" | "relative" | "absolute" | "diagonal";

export interface FormValues {
  limit: string; // empty: no gate; may contain its unit, "0.05 mm"
  units: string; // of the limits; empty: none
  inside: string; // of B; empty with `outside`: no zone; a minus is as good as none
  outside: string;
  further: string; // what no field has: options of the service as a JSON object; empty: none
  unitA: string; // of mesh a; empty: as its file says
  unitB: string;
  direction: Direction;
  toleranceKind: ToleranceKind;
  tolerance: string; // percent if relative or of the diagonal
  strategy: Strategy;
  points: string;
  timeout: string; // seconds; empty: the service's default
  threads: string; // empty: the service decides
  statistics: boolean;
  align: boolean; // A to B, by the best fit
}

export type Field = keyof FormValues;

export interface Mistake {
  field: Field;
  message: string;
}

export type Built = { options: Options; mistakes: [] } | { options: null; mistakes: Mistake[] };

export const noValues: FormValues = {
  limit: "",
  units: "",
  inside: "",
  outside: "",
  further: "",
  unitA: "",
  unitB: "",
  direction: "symmetric",
  toleranceKind: "default",
  tolerance: "",
  strategy: "auto",
  points: "4",
  timeout: "",
  threads: "",
  statistics: false,
  align: false,
};

export const pointChoices = [4, 10, 31, 109, 409, 1585] as const;
export const longestTimeoutS = 180;
const mostThreads = 64;

export function buildOptions(values: FormValues): Built {
  const mistakes: Mistake[] = [];
  const blame: BlameField = (field) => (message) => void mistakes.push({ field, message });
  const further = furtherOf(values.further);
  if (!further) blame("further")('The further options have to be an object in JSON, like {"expect": {"watertight": true}}.');
  const options = merged(fieldsOf(values, blame), further ?? {}, blame("further"));
  if (isObject(options.gate)) {
    const ofNothing = Object.keys(options.gate).every((key) => key === "units");
    if (ofNothing && values.units !== "" && mistakes.length === 0) blame("units")("The unit belongs to the limit: enter a limit, or choose no unit.");
    options.gate = { narrow: true, ...options.gate };
  }
  return mistakes.length > 0 ? { options: null, mistakes } : { options, mistakes: [] };
}

// What the fields say, without the further options.
function fieldsOf(values: FormValues, blame: BlameField) {
  return {
    ...gateOf(values, blame),
    ...unitsDeclared(values),
    ...(values.direction === "symmetric" ? {} : { direction: values.direction }),
    ...toleranceOf(values, blame("tolerance")),
    ...strategyOf(values, blame("points")),
    ...timeoutOf(values.timeout, blame("timeout")),
    ...threadsOf(values.threads, blame("threads")),
    ...(values.statistics ? { statistics: true } : {}),
    ...(values.align ? { align: "rigid" } : {}),
  };
}

type Json = Record<string, unknown>;

const isObject = (value: unknown): value is Json => typeof value === "object" && value !== null && !Array.isArray(value);

/** Parses the field `further`, whose members the service checks; null: not an object in JSON. */
export function furtherOf(text: string): Json | null {
  try {
    const further: unknown = JSON.parse(text.trim() || "{}");
    return isObject(further) ? further : null;
  } catch {
    return null;
  }
}

/** Whether `options` have what a JSON pointer points at, or an array or number on the way to it. */
export function hasPlace(options: Json, pointer: string): boolean {
  let at: unknown = options;
  for (const key of pointer.split("/").slice(1)) {
    if (!isObject(at)) break;
    if (!Object.hasOwn(at, key)) return false;
    at = at[key];
  }
  return true;
}

// Merges the members of objects in both; blames any other member of both.
function merged(fields: Json, further: Json, blame: Blame, place = ""): Json {
  const shared = Object.keys(further).filter((key) => Object.hasOwn(fields, key));
  const both = shared.map((key) => {
    const [field, more] = [fields[key], further[key]], name = place + key;
    if (isObject(field) && isObject(more)) return [key, merged(field, more, blame, `${name}.`)] as const;
    blame(`"${name}" is asked for by another field, too: leave it out here, or empty that field.`);
    return [key, field] as const;
  });
  return { ...fields, ...further, ...Object.fromEntries(both) };
}

// Returns the members that `covered` does not have, of objects in both likewise.
function without(options: Json, covered: Json): Json {
  const left = Object.entries(options).flatMap(([key, value]) => {
    if (!Object.hasOwn(covered, key)) return [[key, value] as const];
    const other = covered[key], inner = isObject(value) && isObject(other) ? without(value, other) : {};
    return Object.keys(inner).length > 0 ? [[key, inner] as const] : [];
  });
  return Object.fromEntries(left);
}

type Blame = (message: string) => void;
type BlameField = (field: Field) => Blame;

/** Parses a number as users and programs write it; null: not a number. */
export function parseNumber(text: string): number | null {
  const value = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text.trim()) ? Number(text.trim()) : NaN;
  return Number.isFinite(value) ? value : null;
}

function numberOf(text: string, what: string, blame: Blame): number | null {
  const value = parseNumber(text);
  if (value === null) {
    const comma = /^\s*[+-]?\d*,\d+(\s*[^\s\d.,].*)?$/.test(text) ? ": write a point, not a comma" : ", like 0.05 or 1e-3";
    blame(`${what} has to be a number${comma}.`);
    return null;
  }
  if (value < 0) blame(`${what} cannot be negative.`);
  return value < 0 ? null : value;
}

/** Splits "0.05 mm" into number and unit. */
export function splitLimit(text: string): { number: string; units: string } {
  const whole = text.trim();
  const number = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?/i.exec(whole)?.[0] ?? "";
  const units = whole.slice(number.length).trim();
  return number !== "" && /^[^\d.,+-]\D*$/.test(units) ? { number, units } : { number: whole, units: "" };
}

// The limit may be among the further options.
function gateOf(values: FormValues, blame: BlameField): { gate?: Json } {
  const units = values.units.trim();
  const zone = zoneOf(values, blame);
  const limit = values.limit.trim() === "" ? {} : distanceLimit(values, units, blame("limit"), blame("units"));
  const gate = { ...limit, ...(zone ? { zone } : {}), ...(units === "" ? {} : { units }) };
  return Object.keys(gate).length > 0 ? { gate } : {};
}

function zoneOf({ inside, outside }: FormValues, blame: BlameField): [number, number] | null {
  if (inside.trim() === "" && outside.trim() === "") return null;
  const limit = (field: "inside" | "outside", text: string) => {
    if (text.trim() !== "") return numberOf(text.trim().replace(field === "inside" ? /^-/ : /^\+/, ""), "The limit", blame(field));
    blame(field)("Enter both limits; 0 for a side that allows nothing.");
    return null;
  };
  const below = limit("inside", inside), above = limit("outside", outside);
  return below === null || above === null ? null : [0 - below, above];
}

function distanceLimit(values: FormValues, named: string, blame: Blame, blameUnits: Blame): NonNullable<Options["gate"]> {
  const { number, units: written } = splitLimit(values.limit);
  if (written.startsWith("%")) {
    blame("A percentage is not possible here: enter a length.");
    return {};
  }
  const limit = numberOf(number, "The limit", blame);
  const units = named || written;
  if (written !== "" && named !== "" && written !== named) {
    blameUnits(`The limit is in "${written}" and the unit is "${named}": enter only one of them.`);
    return {};
  }
  if (limit === null) return {};
  return { max_distance: limit, ...(units === "" ? {} : { units }) };
}

function unitsDeclared({ unitA, unitB }: FormValues): Pick<Options, "units"> {
  if (unitA === "" && unitB === "") return {};
  return { units: { ...(unitA === "" ? {} : { a: unitA }), ...(unitB === "" ? {} : { b: unitB }) } };
}

function toleranceOf(values: FormValues, blame: Blame): Pick<Options, "tolerance"> {
  if (values.toleranceKind === "default") return {};
  if (values.tolerance.trim() === "") {
    blame("Enter a width, or choose the default.");
    return {};
  }
  const value = numberOf(values.tolerance, "The width", blame);
  if (value === null) return {};
  const tolerance: Tolerance = { [values.toleranceKind]: values.toleranceKind === "absolute" ? value : value / 100 };
  return { tolerance };
}

function strategyOf(values: FormValues, blame: Blame): Pick<Options, "strategy" | "points"> {
  if (values.strategy === "auto") return {};
  if (values.strategy !== "n_point") return { strategy: values.strategy };
  const points = pointChoices.find((choice) => String(choice) === values.points);
  if (points === undefined) blame(`Samples a piece: one of ${pointChoices.join(", ")}.`);
  return points === undefined ? {} : { strategy: "n_point", points };
}

function timeoutOf(text: string, blame: Blame): Pick<Options, "timeout_ms"> {
  if (text.trim() === "") return {};
  const seconds = numberOf(text, "The time", blame);
  if (seconds === null) return {};
  const timeout_ms = Math.round(seconds * 1000);
  if (timeout_ms < 1 || timeout_ms > longestTimeoutS * 1000) {
    blame(`The time has to be from 0.001 to ${String(longestTimeoutS)} seconds.`);
    return {};
  }
  return { timeout_ms };
}

function threadsOf(text: string, blame: Blame): Pick<Options, "threads"> {
  if (text.trim() === "") return {};
  const threads = parseNumber(text);
  if (threads === null || !Number.isInteger(threads) || threads < 1 || threads > mostThreads) {
    blame(`Threads: a whole number from 1 to ${String(mostThreads)}.`);
    return {};
  }
  return { threads };
}

/** Returns the form values that lead to a result like this one, without time and threads, which the result does not have. */
export function valuesOf(result: Comparison): FormValues {
  const asked = optionsOf(result), { units = {}, gate } = asked;
  const values = {
    ...noValues,
    limit: String(gate?.max_distance ?? ""),
    units: gate?.units ?? "",
    inside: String(result.gate?.zone ? 0 - result.gate.zone[0] : ""),
    outside: String(result.gate?.zone?.[1] ?? ""),
    unitA: units.a ?? "",
    unitB: units.b ?? "",
    direction: result.direction,
    ...toleranceValues(result.tolerance.asked),
    strategy: result.engine.strategy,
    points: String(result.engine.points ?? 4),
    statistics: result.statistics !== null,
    align: asked.align === "rigid",
  };
  const { gate: covered, ...others } = fieldsOf(values, () => () => undefined);
  const further = without(asked, { ...others, gate: { narrow: true, ...covered } });
  return { ...values, further: Object.keys(further).length > 0 ? JSON.stringify(further) : "" };
}

// The form has one rule; if a request had several, the first one that differs from the default pair.
function toleranceValues(asked: Tolerance): Pick<FormValues, "toleranceKind" | "tolerance"> {
  if (asked.absolute === undefined && asked.relative === 0.01 && asked.diagonal === 1e-6) return { toleranceKind: "default", tolerance: "" };
  if (asked.absolute !== undefined) return { toleranceKind: "absolute", tolerance: String(asked.absolute) };
  const [kind, share] = asked.relative === undefined ? (["diagonal", asked.diagonal ?? 0] as const) : (["relative", asked.relative] as const);
  return { toleranceKind: kind, tolerance: String(Number((share * 100).toPrecision(12))) };
}
