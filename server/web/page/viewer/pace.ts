// The time of each frame, and the level of detail that it allows while the picture moves. A graphics card draws everything;
// for software rendering the mesh gets coarser and the picture smaller, until a frame is fast enough. At rest everything is
// drawn in full.

export interface Fineness {
  scale: number; // of the picture's width and height in pixels
  coarse: 0 | 1 | 2; // of the mesh: all triangles, fewer, very few (kCoarse)
}

export const kCoarse = [Infinity, 16_000, 5_000] as const; // triangles

const kTooSlow = 90; // ms of a frame
const kEasy = 30;
const kLevels: readonly Fineness[] = [
  { scale: 1, coarse: 0 },
  { scale: 0.7, coarse: 0 },
  { scale: 0.7, coarse: 1 },
  { scale: 0.5, coarse: 1 },
  { scale: 0.5, coarse: 2 },
  { scale: 0.3, coarse: 2 },
];

export class Pace {
  private level: number;
  private readonly finest: number;
  private easy = 0;

  // For software rendering it starts coarse: the first full frame would be too slow, however fast those of the coarse mesh
  // are.
  constructor(slow: boolean, triangles: number) {
    const large = slow && triangles > 50_000;
    this.finest = large ? 2 : 0;
    this.level = large ? 4 : slow ? 1 : 0;
  }

  get moving(): Fineness {
    return kLevels[this.level]!;
  }

  // Call with the time that a frame at `moving` took.
  took(ms: number): void {
    if (ms > kTooSlow) {
      this.level = Math.min(this.level + (ms > 2 * kTooSlow ? 2 : 1), kLevels.length - 1);
      this.easy = -20; // not back at once
    } else if (ms >= kEasy) {
      this.easy = Math.min(this.easy, 0);
    } else if (++this.easy > 12 && this.level > this.finest) {
      --this.level;
      this.easy = 0;
    }
  }
}

const kKept = 4000;
const kGivenUp = 3000; // ms, for browsers that never report the end

// Measures frames, from the start until the graphics process has drawn them. It polls once per frame, so times are rounded up
// to the screen's next frame.
export class FrameClock {
  private fence: WebGLSync | null = null;
  private begun = 0;
  private done: (ms: number) => void = () => undefined;
  private moving = false;
  private readonly times: number[] = [];

  constructor(private readonly gl: WebGL2RenderingContext) {}

  // Times of the last frames while the picture moved, in ms.
  frameTimes(): number[] {
    return [...this.times];
  }

  forget(): void {
    this.times.length = 0;
  }

  // True: the last frame is still being drawn.
  busy(): boolean {
    if (!this.fence) return false;
    const waited = performance.now() - this.begun;
    const ready = this.gl.getSyncParameter(this.fence, this.gl.SYNC_STATUS) === this.gl.SIGNALED;
    if (!ready && waited < kGivenUp && !this.gl.isContextLost()) return true;
    this.gl.deleteSync(this.fence);
    this.fence = null;
    if (this.moving && this.times.push(waited) > kKept) this.times.shift();
    this.done(waited);
    return false;
  }

  // Call when the frame that started at `begun` was submitted; `done` gets its time.
  given(begun: number, moving: boolean, done: (ms: number) => void): void {
    this.begun = begun;
    this.moving = moving;
    this.done = done;
    this.fence = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.gl.flush();
  }

  dispose(): void {
    if (this.fence) this.gl.deleteSync(this.fence);
    this.fence = null;
  }
}
