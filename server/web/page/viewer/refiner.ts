// Draws the full picture in small portions for software rendering: a million triangles at once would block all input. It
// draws off screen, and the last moving picture stays until it is complete. Drawn at twice the size and averaged, so that
// edges are as smooth as with a graphics card.
import {
  GLSL3,
  LinearFilter,
  Mesh,
  NoBlending,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  WebGLRenderTarget,
  type BufferGeometry,
  type Camera,
  type Object3D,
  type WebGLRenderer,
} from "three";
import type { Rect } from "./camera";

const kBudget = 45; // ms of a portion
const kLeast = 1500; // indices of a portion
const kFirst = 12_000; // of the first portion of an object: lines take longer than triangles, and glass than what it covers

// One part of the canvas: objects in the order to draw them.
export interface PartToDraw {
  rect: Rect; // CSS pixels from the lower left corner of the canvas
  objects: (Object3D & { geometry: BufferGeometry })[];
  prepare: () => void; // sets uniforms and lens
}

export class Refiner {
  private readonly target = new WebGLRenderTarget(1, 1, { minFilter: LinearFilter, magFilter: LinearFilter, generateMipmaps: false });
  private readonly sheet: Mesh<PlaneGeometry, ShaderMaterial>;
  private readonly sheetScene = new Scene();
  private parts: PartToDraw[] = [];
  private at = { part: 0, object: 0, index: 0 };
  private portion = kFirst; // indices
  private ratio = 1; // pixels of the target for one CSS pixel
  private size = { width: 1, height: 1 };
  active = false;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly scene: Scene,
    private readonly camera: Camera,
  ) {
    const material = new ShaderMaterial({
      uniforms: { picture: { value: this.target.texture } },
      vertexShader: "out vec2 place; void main() { place = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: "uniform sampler2D picture; in vec2 place; out vec4 colour; void main() { colour = texture(picture, place); }",
      glslVersion: GLSL3,
      blending: NoBlending,
      depthTest: false,
      depthWrite: false,
    });
    this.sheet = new Mesh(new PlaneGeometry(2, 2), material);
    this.sheet.frustumCulled = false;
    this.sheetScene.add(this.sheet);
  }

  begin(parts: PartToDraw[], width: number, height: number, ratio: number): void {
    this.parts = parts;
    this.at = { part: 0, object: 0, index: 0 };
    this.active = true;
    this.target.setSize(Math.floor(width * ratio), Math.floor(height * ratio));
    this.ratio = ratio;
    this.size = { width, height };
    this.renderer.setRenderTarget(this.target);
    this.target.scissorTest = false;
    this.renderer.clear();
    this.renderer.setRenderTarget(null);
  }

  // Draws the next portion; false: nothing is left.
  step(): boolean {
    const part = this.parts[this.at.part];
    const object = part?.objects[this.at.object];
    if (!part) return false;
    if (!object) {
      this.at = { part: this.at.part + 1, object: 0, index: 0 };
      return this.step();
    }
    const size = object.geometry.getIndex()?.count ?? 0;
    const count = Math.min(this.portion, size - this.at.index);
    this.drawPortion(part, object, this.at.index, count);
    if (this.at.index + count < size) this.at.index += count;
    else {
      this.at = { part: this.at.part, object: this.at.object + 1, index: 0 };
      this.portion = Math.min(this.portion, kFirst);
    }
    return true;
  }

  // Sets the next portion's size by the time that the last one took.
  took(ms: number): void {
    const factor = Math.min(2, Math.max(0.4, kBudget / Math.max(ms, 1)));
    this.portion = Math.max(kLeast, 6 * Math.round((this.portion * factor) / 6));
  }

  // Copies the finished picture to the canvas.
  present(): void {
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, this.size.width, this.size.height);
    this.renderer.render(this.sheetScene, this.camera);
    this.active = false;
  }

  dispose(): void {
    this.target.dispose();
    this.sheet.geometry.dispose();
    this.sheet.material.dispose();
  }

  private drawPortion(part: PartToDraw, object: PartToDraw["objects"][number], start: number, count: number): void {
    part.prepare();
    for (const one of part.objects) one.visible = one === object;
    const [x, y, w, h] = [part.rect.left, part.rect.top, part.rect.width, part.rect.height].map((v) => Math.round(v * this.ratio));
    this.target.viewport.set(x!, y!, w!, h!);
    this.target.scissor.set(x!, y!, w!, h!);
    this.target.scissorTest = true;
    object.geometry.setDrawRange(start, count);
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(this.scene, this.camera);
    this.renderer.setRenderTarget(null);
    object.geometry.setDrawRange(0, Infinity);
  }
}
