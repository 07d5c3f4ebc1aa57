// The options of a request from what a user typed. Numbers and texts go as they are: the service says what is wrong with
// them, and form.ts shows it at the field.
import type { Comparison, Direction, Strategy, Tolerance } from "../api/types.js";
import { optionsOf } from "../text/snippets.js";

type ToleranceKind = "default" | "relative" | "absolute" | "diagonal";

/** The fields of the form, each with its value at the start. */
export const noValues = {
  limit: "", // empty: no gate; may have its unit with it, "0.05 mm" or "0.5 %"
  units: "", // of the limits; empty: none
  inside: "", // of B; empty with `outside`: no limits of sides; a minus is as good as none
  outside: "",
  further: "", // what no field has: options of the service as a JSON object; empty: none
  unitA: "", // of mesh a; empty: as its file says
  unitB: "",
  direction: "symmetric" as Direction,
  toleranceKind: "default" as ToleranceKind,
  tolerance: "", // percent if relative or of the diagonal
  strategy: "auto" as Strategy,
  points: "4",
  timeout: "", // seconds, or with a unit; empty: the service's default
  threads: "", // empty: the service decides
  statistics: false,
  align: false, // A to B, by the best fit
};

export type FormValues = typeof noValues;

/** What the service reads as Options (openapi.yaml): it says what is wrong with it. */
export type Json = Record<string, unknown>;

export type Field = keyof FormValues;

export interface Mistake {
  field: Field;
  message: string;
}

export type Built = { options: Json; mistakes: [] } | { options: null; mistakes: Mistake[] };

export function buildOptions(values: FormValues): Built {
  const mistakes: Mistake[] = [];
  const blame: BlameField = (field) => (message) => void mistakes.push({ field, message });
  const further = furtherOf(values.further);
  if (!further) blame("further")('The further options have to be an object in JSON, like {"expect": {"watertight": true}}.');
  const options = merged(fieldsOf(values, blame), further ?? {}, blame("further"));
  if (isObject(options.gate)) options.gate = { narrow: true, ...options.gate };
  return mistakes.length > 0 ? { options: null, mistakes } : { options, mistakes: [] };
}

// What the fields say, without the further options.
function fieldsOf(values: FormValues, blame: BlameField): Json {
  return {
    ...gateOf(values, blame),
    ...unitsDeclared(values),
    ...(values.direction === "symmetric" ? {} : { direction: values.direction }),
    ...toleranceOf(values, blame("tolerance")),
    ...(values.strategy === "auto" ? {} : { strategy: values.strategy }),
    ...(values.strategy === "n_point" ? { points: Number(values.points) } : {}),
    ...(values.timeout.trim() === "" ? {} : { timeout: asTyped(values.timeout) }),
    ...(values.threads.trim() === "" ? {} : { threads: asTyped(values.threads) }),
    ...(values.statistics ? { statistics: true } : {}),
    ...(values.align ? { align: "rigid" } : {}),
  };
}

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

/** "/gate/max_distance" belongs to the field `limit`, unless it is among the further options, as all that no field has. */
export function fieldOf(where: string, further: Json): Field {
  const fields: [RegExp, Field][] = [
    [/^\/gate(\/max_distance)?$/, "limit"], [/^\/gate\/units$/, "units"], [/^\/gate\/zone\/0$/, "inside"], [/^\/gate\/zone/, "outside"],
    [/^\/units\/a$/, "unitA"], [/^\/units\/b$/, "unitB"], [/^\/tolerance/, "tolerance"], [/^\/timeout$/, "timeout"], [/^\/threads$/, "threads"], [/^\/points$/, "points"], [/^\/align$/, "align"], [/^\/direction$/, "direction"],
  ];
  const found = hasPlace(further, where) ? undefined : fields.find(([place]) => place.test(where));
  return found?.[1] ?? "further";
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

/** A number as users and programs write it; else the text, without blanks around it. */
export function asTyped(text: string): number | string {
  const typed = text.trim();
  const value = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(typed) ? Number(typed) : NaN;
  return Number.isFinite(value) ? value : typed;
}

// The limit may be among the further options.
function gateOf(values: FormValues, blame: BlameField): { gate?: Json } {
  const units = values.units.trim();
  const zone = zoneOf(values, blame);
  const limit = values.limit.trim() === "" ? {} : { max_distance: asTyped(values.limit) };
  const gate = { ...limit, ...(zone ? { zone } : {}), ...(units === "" ? {} : { units }) };
  return Object.keys(gate).length > 0 ? { gate } : {};
}

function zoneOf({ inside, outside }: FormValues, blame: BlameField): [number | string, number | string] | null {
  const empty = (["inside", "outside"] as const).filter((field) => (field === "inside" ? inside : outside).trim() === "");
  if (empty.length === 2) return null;
  if (empty[0]) blame(empty[0])("Enter both limits; 0 for a side that allows nothing.");
  const below = asTyped(inside.trim().replace(/^-\s*/, ""));
  return [typeof below === "number" ? 0 - below : `-${below}`, asTyped(outside)];
}

function unitsDeclared({ unitA, unitB }: FormValues): Json {
  if (unitA === "" && unitB === "") return {};
  return { units: { ...(unitA === "" ? {} : { a: unitA }), ...(unitB === "" ? {} : { b: unitB }) } };
}

function toleranceOf({ toleranceKind: kind, tolerance }: FormValues, blame: Blame): { tolerance?: Json } {
  if (kind === "default") return {};
  if (tolerance.trim() === "") blame("Enter a width, or choose the default.");
  const typed = asTyped(tolerance);
  return { tolerance: { [kind]: kind === "absolute" || typeof typed === "string" ? typed : typed / 100 } };
}

/** The limits that a gate has for how far A is inside and outside of B, not negative; null: none. */
export function sidesOf(gate: Comparison["gate"]): { inside: number; outside: number } | null {
  return gate?.zone ? { inside: 0 - gate.zone[0], outside: gate.zone[1] } : null;
}

/** Returns the form values that lead to a result like this one, without time and threads, which the result does not have. */
export function valuesOf(result: Comparison): FormValues {
  const asked = optionsOf(result), { units = {}, gate } = asked, sides = sidesOf(result.gate);
  const values = {
    ...noValues,
    limit: String(gate?.max_distance ?? ""),
    units: gate?.units ?? "",
    inside: String(sides?.inside ?? ""),
    outside: String(sides?.outside ?? ""),
    unitA: units.a ?? "",
    unitB: units.b ?? "",
    direction: result.direction,
    ...toleranceValues(asked.tolerance),
    strategy: result.engine.strategy,
    points: String(result.engine.points ?? 4),
    statistics: result.statistics !== null,
    align: asked.align === "rigid",
  };
  const { gate: covered, ...others } = fieldsOf(values, () => () => undefined);
  const further = without(asked, { ...others, gate: { narrow: true, ...(isObject(covered) ? covered : {}) } });
  return { ...values, further: Object.keys(further).length > 0 ? JSON.stringify(further) : "" };
}

// The form has one rule; if a request had several, the first of these.
function toleranceValues(asked: Tolerance | undefined): Pick<FormValues, "toleranceKind" | "tolerance"> {
  if (!asked) return { toleranceKind: "default", tolerance: "" };
  if (asked.absolute !== undefined) return { toleranceKind: "absolute", tolerance: String(asked.absolute) };
  const [kind, share] = asked.relative === undefined ? (["diagonal", asked.diagonal ?? 0] as const) : (["relative", asked.relative] as const);
  return { toleranceKind: kind, tolerance: String(Number((share * 100).toPrecision(12))) };
}
