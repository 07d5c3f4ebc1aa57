// How long pictures take, from the begin of a frame until the graphics process says that it is done. It is asked once a
// frame: times are rounded up to the screen's next one.

const kKept = 4000;
const kGivenUp = 3000; // ms; a browser that never says

export class FrameClock {
  private fence: WebGLSync | null = null;
  private begun = 0;
  private done: (ms: number) => void = () => undefined;
  private moving = false;
  private readonly times: number[] = [];

  constructor(private readonly gl: WebGL2RenderingContext) {}

  // Of the last frames while the picture moved, in ms.
  frameTimes(): number[] {
    return [...this.times];
  }

  forget(): void {
    this.times.length = 0;
  }

  // Whether the last frame is still being drawn.
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

  // The frame that began at `begun` has been given to the graphics process; `done` hears how long it took.
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
