// Measures frames, from the start until the graphics process has drawn them. It polls once per frame, so times are rounded up
// to the screen's next frame.

const kKept = 4000;
const kGivenUp = 3000; // ms, for browsers that never report the end

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
