// One mesh as three.js draws it: coloured by its distance, as glass over the other one, and its edges. They share one buffer
// of positions and one of distances.
import {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  DoubleSide,
  GLSL3,
  Group,
  LineSegments,
  Mesh as Drawn,
  NearestFilter,
  Points,
  RGBAFormat,
  ShaderMaterial,
  Sphere,
  UnsignedByteType,
  Vector2,
  Vector3,
  Vector4,
  type IUniform,
} from "three";
import { aboveLimit, colourTable, kPaths, kSteps, limitOf, type ColourScale, type Rgb } from "./colours";
import type { DeviationMap } from "./map";
import { kCoarse, type Fineness } from "./pace";
import { kColouredFragment, kLineFragment, kOverlayFragment, kSurfaceVertex } from "./shaders";
import { coarsened, edgesInSteps, signedVolume } from "./shape";
import { sub, type Vec3 } from "./vec";

export type Role = "coloured" | "overlay" | "none";

export interface Look {
  role: Role;
  wire: boolean;
  moving: boolean; // fewer passes and the coarse mesh
  coarse: Fineness["coarse"];
}

export interface Tones {
  faded: Rgb;
  section: Rgb;
  tint: Rgb;
  line: Rgb;
}

const share = ([r, g, b]: Rgb): Vector3 => new Vector3(r / 255, g / 255, b / 255);

// Shared by both meshes of a viewer.
export function makeTable(): DataTexture {
  const texture = new DataTexture(colourTable(), kSteps + 1, kPaths.length, RGBAFormat, UnsignedByteType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

export class Surface {
  readonly group = new Group();
  readonly uniforms: Record<string, IUniform>;
  private readonly positions: BufferAttribute;
  private readonly deviations: BufferAttribute;
  private readonly sides: BufferAttribute | undefined;
  private readonly fine: BufferGeometry;
  private readonly filled = new Map<Fineness["coarse"], BufferGeometry>();
  private edges?: BufferGeometry;
  private edgeSteps?: ReturnType<typeof edgesInSteps>;
  private readonly coloured: Drawn | Points;
  private readonly depth: Drawn | Points;
  private readonly overlay: Drawn | Points;
  private readonly lines: LineSegments;

  constructor(
    private readonly map: DeviationMap,
    { origin, size }: { origin: Vec3; size: number },
    table: DataTexture,
    scale: ColourScale,
  ) {
    this.uniforms = { ...uniformsFor(table, scale, signedVolume(map) >= 0), size: { value: size } };
    this.positions = new BufferAttribute(map.positions, 3);
    this.deviations = new BufferAttribute(map.distances, 1);
    this.sides = map.sides && new BufferAttribute(map.sides, 1);
    this.fine = this.geometryWith(map.indices);
    this.filled.set(0, this.fine);
    const drawn = (material: ShaderMaterial): Drawn | Points => (map.cloud ? new Points(this.fine, material) : new Drawn(this.fine, material));
    this.coloured = drawn(this.material(kColouredFragment, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    // Pushed back further, so that where both surfaces coincide the colours are visible.
    const behind = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4, transparent: true };
    this.depth = drawn(this.material(kOverlayFragment, { ...behind, colorWrite: false }));
    this.overlay = drawn(this.material(kOverlayFragment, behind));
    this.lines = new LineSegments(this.fine, this.material(kLineFragment, { transparent: true, depthWrite: false }));
    [this.coloured, this.depth, this.overlay, this.lines].forEach((object, order) => {
      object.renderOrder = order;
      object.frustumCulled = false;
      this.group.add(object);
    });
    this.group.position.set(...sub(map.translation, origin));
  }

  setLook(look: Look): void {
    const filled = this.filledFor(look.coarse);
    this.coloured.visible = look.role === "coloured";
    this.overlay.visible = look.role === "overlay";
    this.depth.visible = look.role === "overlay" && !look.moving && this.uniforms.opacity!.value < 1;
    this.lines.visible = look.role !== "none" && look.wire && look.coarse === 0 && this.edges !== undefined; // edges of the coarse mesh would mislead
    for (const object of [this.coloured, this.overlay, this.depth]) object.geometry = filled;
    if (this.lines.visible) this.lines.geometry = this.edges!;
    this.lines.renderOrder = look.role === "overlay" ? 6 : 1;
    this.uniforms.strength!.value = look.role === "overlay" ? 0.35 : 0.55;
  }

  // Returns the visible objects in the order to draw them.
  visible(): (Drawn | Points | LineSegments)[] {
    return [this.coloured, this.depth, this.overlay, this.lines].filter((object) => object.visible);
  }

  // Makes it before it is needed, since it takes longer than a frame may.
  prepareCoarse(): void {
    this.filledFor(1);
    this.filledFor(2);
  }

  // Works on the edges for some ms; true: they are ready. Without this call no edges are drawn.
  prepareEdges(ms: number): boolean {
    const end = performance.now() + ms;
    while (!this.edges) {
      const step = (this.edgeSteps ??= edgesInSteps(this.map)).next();
      if (step.done) this.edges = this.geometryWith(step.value);
      else if (performance.now() >= end) return false;
    }
    this.edgeSteps = undefined;
    return true;
  }

  setTones(tones: Tones): void {
    for (const name of ["faded", "section", "tint", "line"] as const) this.uniforms[name]!.value = share(tones[name]);
  }

  dispose(): void {
    for (const geometry of [...this.filled.values(), this.edges]) geometry?.dispose();
    for (const object of [this.coloured, this.depth, this.overlay, this.lines]) (object.material as ShaderMaterial).dispose();
  }

  private geometryWith(indices: Uint32Array): BufferGeometry {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", this.positions);
    geometry.setAttribute("deviation", this.deviations);
    if (this.sides) geometry.setAttribute("side", this.sides);
    geometry.setIndex(new BufferAttribute(indices, 1));
    geometry.boundingSphere = new Sphere(new Vector3(), Infinity); // else three.js computes it from all vertices
    return geometry;
  }

  private filledFor(coarse: Fineness["coarse"]): BufferGeometry {
    let geometry = this.filled.get(coarse);
    if (!geometry) {
      const indices = coarsened(this.map, kCoarse[coarse]);
      geometry = indices === this.map.indices ? this.fine : this.geometryWith(indices);
      this.filled.set(coarse, geometry);
    }
    return geometry;
  }

  private material(fragmentShader: string, options: object): ShaderMaterial {
    return new ShaderMaterial({
      uniforms: this.uniforms,
      vertexShader: kSurfaceVertex,
      fragmentShader,
      defines: { STEPS: kSteps, ...(this.map.cloud ? { CLOUD: 1 } : {}), ...(this.map.sides ? { SIDES: 1 } : {}) },
      glslVersion: GLSL3,
      side: DoubleSide,
      forceSinglePass: true,
      ...options,
    });
  }
}

function uniformsFor(table: DataTexture, scale: ColourScale, outward: boolean): Record<string, IUniform> {
  return {
    table: { value: table },
    top: { value: scale.top },
    limits: { value: kPaths.map((path) => Math.min(limitOf(scale, path), 3e38)) }, // finite in single precision
    above: { value: kPaths.map((path) => share(aboveLimit(path))) },
    outward: { value: outward },
    clip: { value: new Vector4() },
    clipped: { value: false },
    brush: { value: new Vector2() },
    brushed: { value: false },
    plain: { value: false },
    opacity: { value: 0.35 },
    strength: { value: 0.5 },
    faded: { value: new Vector3() },
    section: { value: new Vector3() },
    tint: { value: new Vector3() },
    line: { value: new Vector3() },
  };
}
