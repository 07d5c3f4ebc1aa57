// Parses the options that a user typed, or reports what is wrong, field by field.
import type { Comparison, Direction, Options, Strategy, Tolerance } from "../api/types.js";
import { regionsAsked } from "../text/regions.js";
import { optionsOf } from "../text/snippets.js";

export type ToleranceKind = "default" | "relative" | "absolute" | "diagonal";

export interface FormValues {
  limit: string; // empty: no gate; may contain its unit, "0.05 mm"
  units: string; // of the limits; empty: none
  inside: string; // of B; empty with `outside`: no zone; a minus is as good as none
  outside: string;
  regions: string; // JSON, as the service has it; empty: none
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
  regions: "",
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
  const options: Options = {
    ...gateOf(values, blame),
    ...regionsOf(values.regions, blame("regions")),
    ...unitsDeclared(values),
    ...(values.direction === "symmetric" ? {} : { direction: values.direction }),
    ...toleranceOf(values, blame("tolerance")),
    ...strategyOf(values, blame("points")),
    ...timeoutOf(values.timeout, blame("timeout")),
    ...threadsOf(values.threads, blame("threads")),
    ...(values.statistics ? { statistics: true } : {}),
    ...(values.align ? { align: "rigid" } : {}),
  };
  return mistakes.length > 0 ? { options: null, mistakes } : { options, mistakes: [] };
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

function gateOf(values: FormValues, blame: BlameField): Pick<Options, "gate"> {
  const named = values.units.trim();
  const zone = zoneOf(values, blame);
  if (values.limit.trim() === "") {
    if (zone) return { gate: { zone, narrow: true, ...(named === "" ? {} : { units: named }) } };
    if (named !== "") blame("units")("The unit belongs to the limit: enter a limit, or choose no unit.");
    return {};
  }
  const { gate } = distanceLimit(values, named, blame("limit"), blame("units"));
  return gate ? { gate: { ...gate, ...(zone ? { zone } : {}) } } : {};
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

// The service checks what they are.
function regionsOf(text: string, blame: Blame): Pick<Options, "regions"> {
  if (text.trim() === "") return {};
  try {
    return { regions: JSON.parse(text) as NonNullable<Options["regions"]> };
  } catch {
    blame("The regions have to be a list in JSON.");
    return {};
  }
}

function distanceLimit(values: FormValues, named: string, blame: Blame, blameUnits: Blame): Pick<Options, "gate"> {
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
  return { gate: { max_distance: limit, narrow: true, ...(units === "" ? {} : { units }) } };
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
  const { units = {} } = optionsOf(result);
  return {
    ...noValues,
    limit: String(result.gate?.max_distance ?? ""),
    units: optionsOf(result).gate?.units ?? "",
    inside: String(result.gate?.zone ? 0 - result.gate.zone[0] : ""),
    outside: String(result.gate?.zone?.[1] ?? ""),
    regions: result.regions ? JSON.stringify(regionsAsked(result)) : "",
    unitA: units.a ?? "",
    unitB: units.b ?? "",
    direction: result.direction,
    ...toleranceValues(result.tolerance.asked),
    strategy: result.engine.strategy,
    points: String(result.engine.points ?? 4),
    statistics: result.statistics !== null,
    align: result.alignment !== undefined,
  };
}

// The form has one rule; if a request had several, the first one that differs from the default pair.
function toleranceValues(asked: Tolerance): Pick<FormValues, "toleranceKind" | "tolerance"> {
  if (asked.absolute === undefined && asked.relative === 0.01 && asked.diagonal === 1e-6) return { toleranceKind: "default", tolerance: "" };
  if (asked.absolute !== undefined) return { toleranceKind: "absolute", tolerance: String(asked.absolute) };
  const [kind, share] = asked.relative === undefined ? (["diagonal", asked.diagonal ?? 0] as const) : (["relative", asked.relative] as const);
  return { toleranceKind: kind, tolerance: String(Number((share * 100).toPrecision(12))) };
}
