// The same measurement without the page: a command line, and a gate of `meshgauge check`.
import type { Comparison, MeshFacts, Options } from "../api/types.js";
import { criteriaOf, distancesAsked, rest } from "./criteria.js";
import { toDigits, toDigitsAbove } from "./numbers.js";
import { unitOf } from "./verdict.js";

export interface Names {
  a: string; // file names, as sent
  b: string;
}

/** Returns a shell command. A name that the shell or curl would misread is replaced by a plain one. */
export function curlCommand(origin: string, names: Names, options: Options, withKey: boolean): string {
  const key = withKey ? ' -H "Authorization: Bearer $MESHGAUGE_KEY"' : "";
  const text = JSON.stringify(options);
  const third = text === "{}" ? "" : ` \\\n  -F ${quoted(`options=${text}`)}`;
  const { a, b } = plainNames(names);
  return `curl -sS${key} -F a=@${a} -F b=@${b}${third} \\\n  ${origin}/v1/comparisons`;
}

const quoted = (text: string): string => `'${text.replace(/'/g, "'\\''")}'`;

type UnitsOfEach = Partial<Record<"units", Extract<Options["units"], object>>>;

/** The options that a result states. */
export function optionsOf(result: Comparison): Options & UnitsOfEach {
  const unit = unitOfLimit(result);
  const { gate, direction, tolerance, engine } = result;
  const usual = tolerance.asked.absolute === undefined && tolerance.asked.relative === 0.01 && tolerance.asked.diagonal === 1e-6;
  return {
    ...(gate ? { gate: { ...limitsAsked(gate), narrow: true, ...(unit === null ? {} : { units: unit }) } } : {}),
    ...unitsDeclared(result),
    ...(direction === "symmetric" ? {} : { direction }),
    ...(usual ? {} : { tolerance: tolerance.asked }),
    ...(engine.strategy === "auto" ? {} : { strategy: engine.strategy }),
    ...(engine.points === null ? {} : { points: engine.points as NonNullable<Options["points"]> }),
    ...(result.regions ? { regions: regionsAsked(result) } : {}),
    ...areasAsked(result),
    ...(result.sides && !criteriaOf(result).some(({ side }) => side) ? { sides: { length_tolerance: result.sides.length_tolerance } } : {}),
    ...(result.statistics ? { statistics: true } : {}),
    ...expectAsked(result),
    ...alignAsked(result),
  };
}

/** The same options without the limits, those of regions included. */
export function withoutLimits(options: Options): Options {
  const regions = options.regions?.map((region) => ({ ...region, max_distance: undefined }));
  return { ...options, gate: undefined, ...(regions ? { regions } : {}) };
}

const limitsAsked = (gate: NonNullable<Comparison["gate"]>) =>
  Object.fromEntries(Object.entries(gate).filter(([name, limit]) => name !== "units" && limit !== null)) as NonNullable<Options["gate"]>;

/** The regions as they were asked for: without those that have the gate's limit. */
export function regionsAsked({ regions, gate }: Comparison) {
  const asked = regions?.filter(({ name }) => name !== rest) ?? [];
  return asked.map(({ name, box, sphere, group, max_distance }) => ({
    name,
    ...(box ? { box } : {}),
    ...(sphere ? { sphere } : {}),
    ...(group ? { group } : {}),
    ...(max_distance === undefined || max_distance === gate?.max_distance ? {} : { max_distance }),
  }));
}

// Most expectations imply the topology.
function expectAsked({ expect, meshes }: Comparison): Pick<Options, "expect" | "topology"> {
  const implied = Object.keys(expect ?? {}).some((name) => name !== "triangles" && name !== "degenerate");
  return { ...(expect ? { expect } : {}), ...(meshes.a.topology === undefined || implied ? {} : { topology: true }) };
}

function alignAsked({ alignment }: Comparison): Pick<Options, "align"> {
  if (!alignment) return {};
  const { method, transform, principal_axes, overlap, start } = alignment;
  if (method === "given") return { align: { transform } };
  if (!start && !principal_axes && overlap === 1) return { align: "rigid" };
  return { align: { ...(start ? { transform: start, fit: true } : {}), ...(principal_axes ? { principal_axes } : {}), ...(overlap === 1 ? {} : { overlap }) } };
}

// Without the distances that a limit asks for, which are the last.
function areasAsked(result: Comparison): Pick<Options, "areas"> {
  const { areas } = result;
  const found = areas?.a_to_b ?? areas?.b_to_a;
  if (!areas || !found) return {};
  const all = found.beyond.map(({ distance }) => distance), quantiles = found.quantiles.map(({ share }) => share);
  const beyond = criteriaOf(result).reduce((own, limit) => own.slice(0, own.length - distancesAsked(limit)), all);
  if (beyond.length === 0 && quantiles.length === 0 && !found.mean) return {};
  const { share_tolerance, length_tolerance } = areas;
  return {
    areas: {
      ...(beyond.length ? { beyond } : {}),
      ...(quantiles.length ? { quantiles } : {}),
      ...(found.mean ? { mean: true } : {}),
      share_tolerance,
      length_tolerance,
    },
  };
}

// A number in the unit of mesh b is in the unit of the result.
const unitOfLimit = (result: Comparison): string | null => (result.gate?.units === "b" ? unitOf(result) : (result.gate?.units ?? null));

function unitsDeclared({ meshes: { a, b } }: Comparison): UnitsOfEach {
  const declared = ({ unit }: { unit?: MeshFacts["unit"] }) => (unit?.source === "declared" ? unit.name : null);
  const [one, other] = [declared(a), declared(b)];
  if (one === null && other === null) return {};
  return { units: { ...(one === null ? {} : { a: one }), ...(other === null ? {} : { b: other }) } };
}

/** Returns gates.yaml with this gate. Without a limit, one just above the measured distance. */
export function gatesYaml(result: Comparison, names: Names): string {
  const { a, b } = plainNames(names);
  const stem = a.replace(/(\.gz)?$/, "").replace(/\.[^.]*$/, "") || "part";
  const lines = [
    "# gates.yaml",
    "version: 1",
    "gates:",
    `  - name: ${JSON.stringify(stem)}`,
    `    candidate: ${JSON.stringify(a)}`,
    `    baseline: ${JSON.stringify(`baselines/${b}`)}`,
    ...limitLines(result),
    ...unitsLine(result),
    ...directionLine(result),
    ...cloudLine(result),
    ...alignLine(result),
    ...expectLine(result),
    ...toleranceLine(result),
  ];
  return lines.join("\n") + "\n";
}

function limitLines(result: Comparison): string[] {
  const { gate, distance } = result;
  const unit = gate ? unitOfLimit(result) : unitOf(result);
  const length = (number: string | number) => (unit === null ? String(number) : `${String(number)} ${unit}`);
  if (!gate) {
    const known = length(toDigitsAbove(distance.upper ?? distance.lower, 3));
    return [`    max_distance: ${known}  # just above what was measured: say what is allowed`];
  }
  const yaml = (limit: unknown): string => {
    if (typeof limit === "number") return length(limit);
    if (Array.isArray(limit)) return `[${limit.map(yaml).join(", ")}]`;
    const { distance, share } = limit as { distance: number; share: number };
    return `{distance: ${length(distance)}, share: ${toDigits(100 * share, 12)} %}`;
  };
  const limits = Object.entries(limitsAsked(gate)).map(([name, limit]) => `    ${name}: ${yaml(limit)}`);
  return [...limits, ...regionLines(result, length)];
}

function regionLines(result: Comparison, length: (number: number) => string): string[] {
  const regions = regionsAsked(result).map(({ max_distance, ...region }) => JSON.stringify({ ...region, ...(max_distance === undefined ? {} : { max_distance: length(max_distance) }) }));
  return regions.length ? ["    regions:", ...regions.map((region) => `      - ${region}`)] : [];
}

function unitsLine(result: Comparison): string[] {
  const { units } = optionsOf(result);
  if (!units) return [];
  const both = [...(units.a ? [`candidate: ${units.a}`] : []), ...(units.b ? [`baseline: ${units.b}`] : [])];
  return [`    units: {${both.join(", ")}}`];
}

function directionLine(result: Comparison): string[] {
  if (result.direction === "symmetric") return [];
  return [`    direction: ${result.direction === "a_to_b" ? "candidate_to_baseline" : "baseline_to_candidate"}`];
}

// Points without faces have to be declared, but for a format that has nothing else.
function cloudLine({ meshes: { a } }: Comparison): string[] {
  return a.triangles === 0 && a.format !== "xyz" ? ["    cloud: true"] : [];
}

// JSON is YAML.
function alignLine(result: Comparison): string[] {
  const { align } = optionsOf(result);
  return align === undefined ? [] : [`    align: ${typeof align === "string" ? align : JSON.stringify(align)}`];
}

function expectLine({ expect }: Comparison): string[] {
  if (!expect) return [];
  const within = expect.volume?.within;
  const volume = within === undefined ? expect.volume : { ...expect.volume, within: `${toDigits(100 * Number(within), 12)} %` };
  return [`    expect: ${JSON.stringify({ ...expect, volume })}`];
}

function toleranceLine(result: Comparison): string[] {
  const { tolerance } = optionsOf(result);
  if (!tolerance) return [];
  const rules = Object.entries(tolerance).map(([rule, value]) => `${rule}: ${String(value)}`);
  return [`    tolerance: {${rules.join(", ")}}`];
}

export function checkCommand(origin: string): string {
  return `meshgauge check gates.yaml --server ${origin}`;
}

function plainNames(names: Names): Names {
  const a = plainName(names.a, "candidate");
  const b = plainName(names.b, "baseline");
  return a === b ? { a, b: `baseline-${b}` } : { a, b };
}

// "@x.stl", ";type=" and "{stem}" have a meaning to one of the programs.
function plainName(name: string, otherwise: string): string {
  if (/^[A-Za-z0-9_][A-Za-z0-9_.-]*$/.test(name)) return name;
  const suffix = /(\.[A-Za-z0-9]{1,5}(\.gz)?)$/.exec(name)?.[1] ?? "";
  return otherwise + suffix;
}
